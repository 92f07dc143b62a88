// Stop and recover, for whoever opened the page by the address that the server printed.

export class Controls {
  constructor() {
    this.token = takeToken();
    this.answer = document.getElementById("answer");
    for (const name of ["stop", "recover"]) {
      const button = document.getElementById(name);
      button.disabled = !this.token;
      button.title = this.token ? "" : "open the page by the whole address that the server printed";
      button.addEventListener("click", () => this.ask(name));
    }
  }

  async ask(name) {
    this.answer.textContent = "";
    try {
      const answer = await fetch(`/${name}`, { method: "POST", headers: { Authorization: `Bearer ${this.token}` } });
      if (!answer.ok) this.answer.textContent = `could not ${name}: ${await answer.text()}`;
    } catch {
      this.answer.textContent = `could not ${name}: the server is gone; use atas ${name === "stop" ? "estop" : name}`;
    }
  }
}

/** The token stands behind the # once; afterwards only this tab knows it. */
function takeToken() {
  const given = location.hash.slice(1);
  if (/^[0-9a-f]{32}$/.test(given)) {
    sessionStorage.setItem("token", given);
    history.replaceState(null, "", location.pathname);
  }
  return sessionStorage.getItem("token");
}
