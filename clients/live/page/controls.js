// Stop and recover buttons; enabled by the token in the address that the server printed.

export class Controls {
  constructor() {
    this.answer = document.getElementById("answer");
    this.buttons = ["stop", "recover"].map((name) => document.getElementById(name));
    for (const button of this.buttons) button.addEventListener("click", () => this.ask(button.id));
    // Entering the full address in an open tab changes only the hash and does not reload the page.
    addEventListener("hashchange", () => this.admit());
    this.admit();
  }

  admit() {
    this.token = takeToken();
    for (const button of this.buttons) {
      button.disabled = !this.token;
      button.title = this.token ? "" : "disabled without a token; open the full address that the server printed";
    }
  }

  async ask(name) {
    this.answer.textContent = "";
    try {
      const answer = await fetch(`/${name}`, { method: "POST", headers: { Authorization: `Bearer ${this.token}` } });
      if (!answer.ok) this.answer.textContent = `could not ${name}: ${await answer.text()}`;
    } catch {
      this.answer.textContent = `could not ${name}: no connection to the server; run atas ${name === "stop" ? "estop" : name}`;
    }
  }
}

/** Moves the token from the hash of the address to the session storage of this tab. */
function takeToken() {
  const given = location.hash.slice(1);
  if (/^[0-9a-f]{32}$/.test(given)) {
    sessionStorage.setItem("token", given);
    history.replaceState(null, "", location.pathname);
  }
  return sessionStorage.getItem("token");
}
