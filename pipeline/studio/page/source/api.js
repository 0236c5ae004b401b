// Requests to the studio's server, each with the token of the address.

const script = document.getElementById("studio-script");
const token = script.dataset.token;
// Whether this tab had the page before, and loads it again.
export const isAgain = new URLSearchParams(location.search).has("again");
// So that the token stands in no history and no screenshot; this tab keeps it to be loaded again.
history.replaceState(null, "", "/");
sessionStorage.studioToken = token;
// So that pages that are open beside each other keep their own takes, also when they are loaded again.
// While a page is open its name is not in storage, which a duplicated tab copies.
const page = sessionStorage.studioPage ?? crypto.randomUUID();
sessionStorage.removeItem("studioPage");
window.addEventListener("pagehide", () => (sessionStorage.studioPage = page));

export class Refusal extends Error {
  constructor(status, answer) {
    super(answer.error);
    this.status = status;
    this.problems = answer.problems || [];
  }
}

// Does work, reports the first line of a refusal, and tells whether the work was done.
export async function guarded(report, work) {
  try {
    return (await work()) !== false;
  } catch (error) {
    if (!(error instanceof Refusal)) throw error;
    report(error.message.split("\n")[0], true);
    return false;
  }
}

async function request(name, message) {
  let response;
  try {
    response = await fetch(`/api/${name}`, {
      method: "POST",
      headers: { "content-type": "application/json", "x-studio-token": token },
      body: JSON.stringify({ ...message, page }),
    });
  } catch {
    throw new Refusal(0, { error: "pronk studio does not answer; start it again and open its new address" });
  }
  if (response.ok) return response;
  const text = await response.text();
  let answer;
  try {
    answer = JSON.parse(text);
  } catch {
    answer = { error: text };
  }
  throw new Refusal(response.status, answer);
}

export async function ask(name, message = {}) {
  return (await request(name, message)).json();
}

export async function askBytes(name, message = {}) {
  const response = await request(name, message);
  const facts = response.headers.get("x-studio-facts");
  return { bytes: await response.arrayBuffer(), facts: facts ? JSON.parse(facts) : {} };
}

// Keeps one message in flight: of what is asked meanwhile only the last is sent.
export function latest(send) {
  let waiting = null;
  let busy = false;
  const put = async (message) => {
    waiting = { message };
    if (busy) return;
    busy = true;
    try {
      while (waiting) {
        const { message: next } = waiting;
        waiting = null;
        await send(next);
      }
    } finally {
      busy = false;
    }
  };
  put.isBusy = () => busy;
  return put;
}
