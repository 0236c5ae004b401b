// The scene player: the take in three dimensions, its time, its sound, and the text beside it.

import { ask, askBytes, latest, Refusal } from "./api.js";
import { Bars } from "./bars.js";
import { textEditor } from "./text_editor.js";
import { TerrainMap } from "./terrain_map.js";
import { Viewer } from "./viewer.js";

const SIMULATE_DELAY = 300; // ms after the last change
const HEARD = 0.7; // seconds of an event that is clicked

export class Player {
  constructor(report) {
    this.report = report;
    this.playing = false;
    this.loops = true;
    this.camera = "free";
    this.bars = new Bars(document.getElementById("timeline"), (time) => this.seek(time), (event) => this.hear(event));
    this.audio = new Audio();
    this.check = latest((message) => this.#check(message));
    this.#buildTransport();
    window.addEventListener("keydown", (event) => this.#key(event));
  }

  async open(document_) {
    this.document = document_;
    this.facts = null;
    this.viewer ??= new Viewer(document.getElementById("world"));
    this.viewer.clear();
    this.viewer.resize();
    if (!this.editor) {
      const schema = await ask("schema", { kind: "scene" });
      this.editor = textEditor(document.getElementById("text"), schema, () => this.#changed());
    }
    this.map ??= new TerrainMap(document.getElementById("map"), this.viewer, this.editor);
    this.editor.text = document_.text;
    if (!this.ticking) {
      this.ticking = true;
      this.last = performance.now();
      requestAnimationFrame((now) => this.#tick(now));
    }
  }

  get isDirty() {
    return this.editor && this.editor.text !== this.document.text;
  }

  // What is saved.
  get content() {
    return { text: this.editor.text };
  }

  // The file holds now what is shown.
  wasSaved() {}

  #message() {
    return { text: this.editor.text, name: this.document.name, kind: "scene" };
  }

  #changed() {
    this.changed = performance.now();
    this.changeShown = null;
    this.onChange?.();
    this.map?.draw();
    this.check(this.#message());
  }

  async #check(message) {
    clearTimeout(this.timer);
    try {
      await ask("check", message);
      this.mistaken = false;
      this.editor.mark([]);
      this.timer = setTimeout(() => this.simulate(), SIMULATE_DELAY);
    } catch (error) {
      if (!(error instanceof Refusal)) throw error;
      this.mistaken = true;
      this.editor.mark(error.problems.length ? error.problems : [{ line: 1, column: 1, path: "", message: error.message }]);
      this.report(error.message.split("\n")[0], true);
    }
  }

  async simulate() {
    const started = performance.now();
    const { changed } = this;
    this.report("simulating …");
    try {
      const request = crypto.randomUUID();
      this.request = request;
      const whole = ask("take", { ...this.#message(), request });
      this.#showFirst(request, changed);
      const facts = await whole;
      const { bytes } = await askBytes("take.glb", { play: facts.play });
      this.request = null;
      this.facts = facts;
      const time = Math.min(this.viewer.time, facts.seconds);
      await this.viewer.show(bytes);
      this.bars.show(facts);
      this.map.forbidden = facts.forbidden;
      this.map.carriers = facts.carriers;
      this.map.draw();
      this.seek(time);
      await this.#showChannels(facts.performers.includes(this.who) ? this.who : "");
      this.#reportTake(`${facts.frames} frames in ${((performance.now() - started) / 1000).toFixed(1)} s`);
      this.takes = (this.takes ?? 0) + 1;
      this.#noteShown(changed);
      this.film = null;
      await this.#fetchSound(facts.play);
    } catch (error) {
      if (!(error instanceof Refusal)) throw error;
      if (error.status === 409) return;
      this.editor.mark(error.problems);
      this.report(error.message.split("\n")[0], true);
    }
  }

  // A mistake that was typed meanwhile matters more.
  #reportTake(text) {
    if (!this.mistaken) this.report(text);
  }

  // What is simulated so far, more and more of it while the rest is.
  async #showFirst(request, changed) {
    this.beginnings = [];
    try {
      for (let after = 0; this.request === request; ) {
        const { bytes, facts } = await askBytes("first-frames", { request, after });
        if (this.request !== request) return;
        if (!after) this.#begin();
        this.facts = null;
        await this.viewer.show(bytes);
        if (this.request !== request) return;
        this.facts = { ...facts, play: null, events: [], notes: [], performers: [], gait: [] };
        this.bars.show({ seconds: facts.whole, known: facts.seconds });
        this.seek(Math.min(this.viewer.time, facts.seconds));
        this.#noteShown(changed);
        this.beginnings.push(facts.frames);
        this.#reportTake(`simulating …; the first ${facts.seconds.toFixed(1)} s of ${facts.whole.toFixed(1)} s are there`);
        after = facts.frames;
      }
    } catch (error) {
      // It has ended before, or another has begun.
      if (!(error instanceof Refusal)) throw error;
    }
  }

  // How long the frames of a change took to be shown [ms], until the next change.
  #noteShown(changed) {
    if (changed === this.changed) this.changeShown ??= performance.now() - changed;
  }

  // The sound and the channels are those of the take before.
  #begin() {
    this.pause();
    this.hasSound = false;
    this.film = null;
    this.bars.showChannels({ curves: [], strips: [] });
  }

  async #showChannels(who) {
    this.who = who;
    if (!this.facts?.play) return;
    this.#about(who);
    const { play } = this.facts;
    const channels = who ? await ask("channels", { play, who }) : { curves: [], strips: [] };
    if (this.facts?.play === play && this.who === who) this.bars.showChannels(channels);
  }

  async #fetchSound(play) {
    const { bytes } = await askBytes("sound", { play });
    if (this.facts?.play !== play) return;
    URL.revokeObjectURL(this.audio.src);
    this.audio.src = URL.createObjectURL(new Blob([bytes], { type: "audio/wav" }));
    this.hasSound = true;
    this.film = (await ask("camera", { play })).camera;
  }

  #about(who = "") {
    const { facts } = this;
    const notes = facts.notes.map((note) => `${note.time.toFixed(2)} s: ${note.text}`);
    const sounds = facts.events.filter((event) => !who || event.who === who).length;
    const head = who ? `${who}: ${sounds} sounds` : `${facts.performers.join(", ")}; ${sounds} sounds`;
    document.getElementById("about").textContent = [head, ...notes].join("\n");
    document.getElementById("about").style.whiteSpace = "pre-line";
  }

  // ---- time

  get time() {
    return this.viewer?.time ?? 0;
  }

  seek(time) {
    if (!this.facts) return;
    if (this.hasSound && Math.abs(this.audio.currentTime - time) > 0.03) this.audio.currentTime = time;
    this.#show(time);
  }

  #show(time) {
    this.viewer.seek(time);
    if (this.camera === "film" && this.film) this.viewer.lookAs(this.film[this.frame - 1]);
    if (this.map?.isShown) this.map.draw(true);
    else this.viewer.draw(true);
    this.bars.time = time;
    this.bars.draw();
    const clock = document.getElementById("clock");
    clock.textContent = `${time.toFixed(2)} s, frame ${this.frame}/${this.facts.frames}`;
  }

  get frame() {
    return Math.min(Math.floor(this.time * this.facts.fps + 1e-6) + 1, this.facts.frames);
  }

  step(frames) {
    this.pause();
    const frame = Math.min(Math.max(this.frame + frames, 1), this.facts.frames);
    this.seek((frame - 1) / this.facts.fps);
  }

  play() {
    if (!this.facts) return;
    this.playing = true;
    if (this.time >= this.facts.seconds - 0.01) this.seek(0);
    if (this.hasSound) this.audio.play();
    this.#refresh();
  }

  pause() {
    clearTimeout(this.hearing);
    this.playing = false;
    this.audio.pause();
    this.#refresh();
  }

  hear(event) {
    this.pause();
    this.seek(Math.max(event.time - 0.05, 0));
    this.play();
    this.hearing = setTimeout(() => this.pause(), HEARD * 1000);
    this.report(`${event.cause} of ${event.who} at ${event.time.toFixed(2)} s`);
  }

  #tick(now) {
    const before = this.last;
    const seconds = Math.min((now - before) / 1000, 0.1);
    this.last = now;
    if (this.playing && this.facts && !document.getElementById("scene").hidden) {
      this.viewer.tookFrame(now - before);
      // The sound keeps the time; without it the page does.
      let time = this.hasSound && !this.audio.paused ? this.audio.currentTime : this.time + seconds;
      if (time >= this.facts.seconds - 1e-3 || (this.hasSound && this.audio.ended)) {
        if (!this.loops) this.pause();
        else if (this.hasSound) void ((this.audio.currentTime = 0), this.audio.play());
        time = this.loops ? 0 : this.facts.seconds;
      }
      this.#show(time);
    }
    requestAnimationFrame((next) => this.#tick(next));
  }

  async still() {
    if (!this.facts?.play) return this.report("a still needs the whole simulation");
    this.pause();
    this.report(`rendering frame ${this.frame} …`);
    try {
      const { bytes } = await askBytes("still", { play: this.facts.play, frame: this.frame });
      const picture = document.getElementById("still");
      picture.src = URL.createObjectURL(new Blob([bytes], { type: "image/png" }));
      picture.hidden = false;
      this.report(`frame ${this.frame} by the renderer; click it away`);
    } catch (error) {
      if (!(error instanceof Refusal)) throw error;
      this.report(error.message.split("\n")[0], true);
    }
  }

  toggleMap() {
    this.map.show(!this.map.isShown);
    this.#refresh();
  }

  // ---- buttons

  #buildTransport() {
    const box = document.getElementById("transport");
    const button = (id, text, title, work) => {
      const one = Object.assign(document.createElement("button"), { id, textContent: text, title });
      one.onclick = work;
      box.append(one);
    };
    button("play", "Play", "Space", () => (this.playing ? this.pause() : this.play()));
    button("back", "◀", "Left: a frame back", () => this.step(-1));
    button("on", "▶", "Right: a frame on", () => this.step(1));
    button("loop", "Loop", "play again and again", () => {
      this.loops = !this.loops;
      this.#refresh();
    });
    button("film-camera", "Film's camera", "as the film sees it", () => {
      this.camera = this.camera === "film" ? "free" : "film";
      this.viewer.controls.enabled = this.camera === "free";
      this.#refresh();
      this.seek(this.time);
    });
    button("see-map", "Map", "M: from above, with the positions of the text to drag", () => this.toggleMap());
    button("render-still", "Still", "R: this frame by pronk's renderer", () => this.still());
    box.append(Object.assign(document.createElement("output"), { id: "clock" }));
    box.append(Object.assign(document.createElement("select"), { id: "preset", title: "quality of the film" }));
    button("render-film", "Render", "the whole film, in the render queue", () => {});
    document.getElementById("still").onclick = (event) => (event.target.hidden = true);
    document.getElementById("world").addEventListener("click", (event) => {
      if (this.facts) this.#showChannels(this.viewer.performerAt(event) ?? "");
    });
    this.#refresh();
  }

  #refresh() {
    document.getElementById("play").textContent = this.playing ? "Pause" : "Play";
    document.getElementById("loop").classList.toggle("on", this.loops);
    document.getElementById("see-map").classList.toggle("on", Boolean(this.map?.isShown));
    document.getElementById("film-camera").classList.toggle("on", this.camera === "film");
  }

  #key(event) {
    if (document.getElementById("scene").hidden || event.ctrlKey || event.metaKey) return;
    if (/INPUT|SELECT|TEXTAREA/.test(event.target.tagName) || event.target.closest(".cm-editor")) return;
    const work = {
      " ": () => (this.playing ? this.pause() : this.play()),
      ArrowLeft: () => this.step(-1),
      ArrowRight: () => this.step(1),
      r: () => this.still(),
      m: () => this.toggleMap(),
    }[event.key];
    if (!work || !this.facts) return;
    event.preventDefault();
    work();
  }
}
