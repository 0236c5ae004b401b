// The library: figures, scenes, materials, dances and voices, with pictures and sounds, to open or
// to begin something new from.

import { ask, askBytes, guarded, Refusal } from "./api.js";

const SHORT = (name) => name.replace(/^library:/, "").replace(/^figures\//, "").replace(/\.yaml$/, "");
const HEARD = ["material", "instrument", "drum"];
const SEEN = ["figure", "scene", "material", "dance"];

function make(tag, words = {}, ...children) {
  const element = Object.assign(document.createElement(tag), words);
  element.append(...children);
  return element;
}

export class Library {
  // `open` opens a document by its name, `create` a new figure (null) or scene by a name.
  constructor(report, open) {
    this.report = report;
    this.open = open;
    this.element = document.getElementById("library");
    this.audio = new Audio();
    this.pictures = new Map();
    this.wanted = [];
    this.seen = new IntersectionObserver((entries) => {
      for (const { target, isIntersecting } of entries) {
        const isWaiting = this.wanted.includes(target);
        if (isIntersecting && !isWaiting && !target.src) this.wanted.push(target);
        else if (!isIntersecting && isWaiting) this.wanted.splice(this.wanted.indexOf(target), 1);
      }
      this.#fetchPictures();
    });
  }

  async show() {
    const { documents, entries } = await ask("library");
    const search = make("input", { type: "search", placeholder: "find", id: "find", ariaLabel: "find" });
    search.oninput = () => this.#filter(search.value.trim().toLowerCase());
    const own = documents.filter(({ name }) => !name.startsWith("library:"));
    const shipped = documents.filter(({ name }) => name.startsWith("library:"));
    const of = (some, kind) => some.filter((one) => one.kind === kind);
    const begin = [
      make("button", { textContent: "new figure", onclick: () => this.open(null) }),
      make("button", { textContent: "new scene", onclick: () => this.#newScene() }),
    ];
    begin[0].dataset.name = "";
    begin[1].dataset.name = "+scene";
    this.seen.disconnect();
    this.wanted = [];
    this.element.replaceChildren(
      make("div", { className: "top" }, ...begin, search),
      ...this.#section("Figures of this folder", of(own, "figure")),
      ...this.#section("Scenes of this folder", of(own, "scene")),
      ...this.#section("Figures", of(shipped, "figure")),
      ...this.#section("Scenes", of(shipped, "scene")),
      ...this.#section("Materials", of(entries, "material")),
      ...this.#section("Dances", of(entries, "dance")),
      ...this.#section("Voices", of(entries, "instrument")),
      ...this.#section("Drums", of(entries, "drum")),
    );
  }

  pause() {
    this.wanted = [];
    this.audio.pause();
  }

  #section(title, some) {
    if (!some.length) return [];
    return [make("h2", { textContent: title }), make("div", { className: "cards" }, ...some.map((one) => this.#card(one)))];
  }

  #card({ name, kind, text = "", group = "" }) {
    const card = make("article", { className: kind, title: [text, group].filter(Boolean).join("; ") });
    card.dataset.words = `${SHORT(name)} ${text} ${group} ${kind}`.toLowerCase();
    const isDocument = kind === "figure" || kind === "scene";
    const fresh = make("button", { textContent: "New", title: isDocument ? `a copy with a name of its own` : "a scene with it" });
    fresh.onclick = () => this.#newFrom(kind, name);
    fresh.dataset.from = `${kind} ${name}`;
    const main = make("button", { className: "name", textContent: SHORT(name) });
    main.dataset.name = name;
    if (isDocument) main.onclick = () => this.open(name);
    else if (HEARD.includes(kind)) main.onclick = () => this.#hear(kind, name, main);
    else main.onclick = () => this.#newFrom(kind, name);
    if (HEARD.includes(kind)) main.prepend("♪ ");
    if (SEEN.includes(kind)) {
      const picture = make("img", { alt: "" });
      Object.assign(picture.dataset, { kind, name });
      picture.onclick = () => main.click();
      const known = this.pictures.get(`${kind} ${name}`);
      if (known) picture.src = known;
      else this.seen.observe(picture);
      card.append(picture);
    }
    card.append(make("div", {}, main, fresh));
    return card;
  }

  #filter(words) {
    for (const card of this.element.querySelectorAll("article")) {
      card.hidden = !words.split(/\s+/).every((word) => card.dataset.words.includes(word));
    }
  }

  // One picture at a time: what is not in the cache has to be rendered.
  async #fetchPictures() {
    if (this.isFetching) return;
    this.isFetching = true;
    while (this.wanted.length && !this.element.hidden) {
      const picture = this.wanted.shift();
      const { kind, name } = picture.dataset;
      try {
        const { bytes } = await askBytes("picture", { kind, name });
        picture.src = URL.createObjectURL(new Blob([bytes], { type: "image/png" }));
        this.pictures.set(`${kind} ${name}`, picture.src);
        // A document of this folder may be another by the next time.
        if (!name.startsWith("library:") && (kind === "figure" || kind === "scene")) this.pictures.delete(`${kind} ${name}`);
      } catch (error) {
        if (!(error instanceof Refusal)) throw error;
        picture.alt = "no picture";
        picture.title = error.message;
        this.seen.unobserve(picture);
      }
    }
    this.isFetching = false;
  }

  #hear(kind, name, button) {
    return guarded(this.report, async () => {
      button.classList.add("on");
      try {
        this.report(`${name}: playing it …`);
        const { bytes } = await askBytes("heard", { kind, name });
        URL.revokeObjectURL(this.audio.src);
        this.audio.src = URL.createObjectURL(new Blob([bytes], { type: "audio/wav" }));
        this.heard = name;
        this.report(name);
        await this.audio.play();
      } finally {
        button.classList.remove("on");
      }
    });
  }

  #newFrom(kind, source) {
    return guarded(this.report, async () => {
      const wished = prompt(`Name of the new ${kind === "figure" ? "figure" : "scene"}`, `my_${SHORT(source).replaceAll(" ", "_")}`);
      if (wished) await this.open((await ask("new-from", { kind, source, name: wished })).name);
    });
  }

  #newScene() {
    return guarded(this.report, async () => {
      const name = prompt("Name of the scene", "hello");
      if (name) await this.open((await ask("new-scene", { name })).name);
    });
  }
}
