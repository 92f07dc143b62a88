// Stop and recover, for whoever opened the page by the address that the server printed.

export class Controls {
  constructor() {
    this.answer = document.getElementById("answer");
    this.buttons = ["stop", "recover"].map((name) => document.getElementById(name));
    for (const button of this.buttons) button.addEventListener("click", () => this.ask(button.id));
    // The whole address, typed into a tab that shows the page already, loads nothing anew.
    addEventListener("hashchange", () => this.admit());
    this.admit();
  }

  admit() {
    this.token = takeToken();
    for (const button of this.buttons) {
      button.disabled = !this.token;
      button.title = this.token ? "" : "open the page by the whole address that the server printed";
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
