// The figure editor: nodes and connections on a canvas, drawn by mouse and keyboard.

import { ask, askBytes, latest, Refusal } from "./api.js";
import { Bars } from "./bars.js";
import { Backdrop } from "./backdrop.js";
import * as sheet from "./drawing.js";
import { FigureText } from "./figure_text.js";
import { Posing } from "./posing.js";
import { Viewer } from "./viewer.js";

const STICKY = 8; // pixels within which a node snaps to an axis, to a line of the grid or is hit
const UNDO_STEPS = 1000;
const WALK_DELAY = 500; // ms after the last change
const NEW_RADIUS = 0.08;
const CLICK = 4; // pixels that a click may move
const BESIDE = 0.2; // m towards the tail, of a node that the keyboard makes
const [BODY, FAINT, INK, WARNING, ACCENT] = ["#64748b", "#8a94a0", "#1f2933", "#b4442f", "#2d6fb4"];

export class Editor {
  constructor(report) {
    this.report = report;
    this.canvas = document.getElementById("canvas");
    this.context = this.canvas.getContext("2d");
    this.viewer = null;
    this.bars = new Bars(document.getElementById("figure-gait"), (time) => this.seek(time));
    this.tool = "select";
    this.lasso = false;
    this.copies = false;
    this.snaps = true;
    this.grid = 0.05;
    this.about = "centre";
    this.view = { x: 0, y: 0, scale: 180 };
    this.groups = [];
    this.sets = [];
    this.playing = true;
    this.metrics = { analysis: [], drawing: [] };
    this.analyse = latest((request) => this.#analyse(request));
    this.walk = latest((request) => this.#walk(request));
    this.backdrop = new Backdrop(this.canvas, report, () => this.refresh());
    this.text = new FigureText(document.getElementById("figure-text"), this, report);
    this.isLocked = false;
    this.#buildTools();
    this.#listen();
    new ResizeObserver(() => this.draw()).observe(document.getElementById("board"));
  }

  async open(document_) {
    this.document = document_;
    this.base = document_.text;
    this.drawing = document_.drawing ?? sheet.empty();
    this.saved = JSON.stringify(this.drawing);
    this.undos = [];
    this.redos = [];
    this.selected = new Set();
    this.edge = null;
    this.loose = null;
    this.groups = [];
    this.sets = [];
    this.analysis = null;
    this.problems = [];
    this.#showAnalysis();
    this.lock(!document_.drawing);
    // Nothing can be selected on an empty board.
    if (!this.isLocked && !Object.keys(this.drawing.nodes).length) this.tool = "draw";
    this.viewer ??= new Viewer(document.getElementById("creature"), { onTheSpot: true });
    this.posing ??= new Posing(this.viewer, document.getElementById("part"), this);
    this.posing.select(null);
    this.walked = null;
    this.viewer.clear();
    this.showStance();
    this.bars.show({ seconds: 1 });
    this.viewer.resize();
    this.backdrop.open(document_.name);
    this.fit();
    this.#changed();
    await this.text.open(document_);
    this.#refreshTools();
    if (!this.ticking) {
      this.ticking = true;
      this.last = performance.now();
      requestAnimationFrame((now) => this.#tick(now));
    }
  }

  get isDirty() {
    if (this.text.typed !== null) return this.text.typed !== this.document.text;
    return this.base !== this.document.text || JSON.stringify(this.drawing) !== this.saved;
  }

  get isEmpty() {
    return this.text.typed === null && !Object.keys(this.drawing.nodes).length;
  }

  // What is saved: the text into which the drawing is put, or one that is no drawing yet.
  get content() {
    if (this.text.typed !== null) return { text: this.text.typed };
    return { text: this.base, drawing: this.drawing };
  }

  // The file holds now what is shown.
  wasSaved() {
    this.base = this.document.text;
    this.saved = JSON.stringify(this.drawing);
    this.backdrop.keep(this.document.name);
    if (this.text.typed !== null) this.text.typed = this.base;
  }

  // ---- changes, undo

  #remember(drawing) {
    this.report("");
    this.undos.push({ base: this.base, drawing });
    if (this.undos.length > UNDO_STEPS) this.undos.shift();
    this.redos = [];
  }

  change(work) {
    this.#remember(JSON.stringify(this.drawing));
    work(this.drawing);
    this.#changed();
  }

  // Ends a drag that changed the drawing: one step of undoing.
  commit(before) {
    this.#remember(before);
    this.#changed();
  }

  // Draws what was typed: one step of undoing until the next change here.
  takeText(base, drawing) {
    if (!this.isTyping) this.#remember(JSON.stringify(this.drawing));
    const isFirst = !Object.keys(this.drawing.nodes).length;
    Object.assign(this, { base, drawing });
    if (isFirst) this.fit();
    if (base === this.document.text) this.saved = JSON.stringify(drawing);
    this.#changed(true);
  }

  // Text that is no figure has no drawing to work on.
  lock(isLocked) {
    this.isLocked = isLocked;
    for (const element of document.querySelectorAll("#tools, #board, #figure aside")) element.inert = isLocked;
    this.#refreshTools();
  }

  #changed(isTyping = false) {
    this.isTyping = isTyping;
    if (!isTyping) this.text.follow();
    for (const name of this.selected) if (!(name in this.drawing.nodes)) this.selected.delete(name);
    this.#refreshTools();
    this.draw();
    this.posing.refresh();
    clearTimeout(this.walkTimer);
    this.walkTimer = null;
    if (this.isLocked || !Object.keys(this.drawing.nodes).length) {
      this.analysis = null;
      return this.#showAnalysis();
    }
    this.analyse(this.#message());
    this.walkTimer = setTimeout(() => {
      this.walkTimer = null;
      this.walk(this.#message());
    }, WALK_DELAY);
  }

  // Whether all that was changed is analysed and walks.
  get isIdle() {
    return !this.walkTimer && ![this.analyse, this.walk, this.text.follow].some((work) => work.isBusy());
  }

  #message() {
    return {
      text: this.base,
      drawing: sheet.copyOf(this.drawing),
      asked: performance.now(),
      is_moving: Boolean(this.drag),
    };
  }

  undo() {
    this.#exchange(this.undos, this.redos);
  }

  redo() {
    this.#exchange(this.redos, this.undos);
  }

  #exchange(from, to) {
    if (!from.length || this.isLocked) return;
    to.push({ base: this.base, drawing: JSON.stringify(this.drawing) });
    const { base, drawing } = from.pop();
    Object.assign(this, { base, drawing: JSON.parse(drawing) });
    this.#changed();
  }

  select(names, keepsOld = false) {
    if (this.selected.size) this.sets.push([...this.selected]);
    const whole = new Set(keepsOld ? this.selected : []);
    for (const name of names) {
      whole.add(name);
      for (const group of this.groups) if (group.includes(name)) group.forEach((one) => whole.add(one));
    }
    this.selected = new Set([...whole].filter((name) => name in this.drawing.nodes));
    this.edge = null;
    this.#refreshTools();
    this.draw();
  }

  previousSet() {
    const set = this.sets.shift();
    if (!set) return;
    this.sets.push([...this.selected]);
    this.selected = new Set(set.filter((name) => name in this.drawing.nodes));
    this.#refreshTools();
    this.draw();
  }

  // ---- operations of the selected set

  deleteSelected() {
    if (this.edge) {
      const [a, b] = this.edge;
      this.edge = null;
      return this.change((drawing) => sheet.disconnect(drawing, a, b));
    }
    if (this.selected.size) this.change((drawing) => sheet.remove(drawing, [...this.selected]));
  }

  transform(map, size = 1, copies = this.copies) {
    const names = [...this.selected];
    if (!names.length) return;
    let made = [];
    this.change((drawing) => (made = sheet.transform(drawing, names, map, copies, size)));
    if (copies) this.select(made);
  }

  get pivot() {
    return this.about === "origin" ? [0, 0] : sheet.centre(this.drawing, [...this.selected]);
  }

  translate(dx, dy, copies) {
    this.transform(([x, y]) => [x + dx, y + dy], 1, copies);
  }

  rotate(degrees) {
    if (!this.selected.size) return;
    const [cx, cy] = this.pivot;
    const [c, s] = [Math.cos((degrees * Math.PI) / 180), Math.sin((degrees * Math.PI) / 180)];
    this.transform(([x, y]) => [cx + c * (x - cx) - s * (y - cy), cy + s * (x - cx) + c * (y - cy)]);
  }

  scale(sx, sy = sx) {
    if (!this.selected.size || !(sx > 0) || !(sy > 0)) return;
    const [cx, cy] = this.pivot;
    this.transform(([x, y]) => [cx + sx * (x - cx), cy + sy * (y - cy)], Math.sqrt(sx * sy));
  }

  mirror(axis) {
    const names = [...this.selected];
    if (!names.length) return;
    if (!this.copies) {
      const map = axis === 0 ? ([x, y]) => [-x, y] : ([x, y]) => [x, -y];
      return this.transform(map, 1, false);
    }
    let made = [];
    this.change((drawing) => (made = sheet.mirror(drawing, names, axis)));
    this.select(made);
  }

  connectSelected(joins) {
    const names = [...this.selected];
    if (names.length < 2) return;
    this.change((drawing) => {
      for (let i = 1; i < names.length; i++) {
        (joins ? sheet.connect : sheet.disconnect)(drawing, names[i - 1], names[i]);
      }
    });
  }

  group() {
    if (this.selected.size > 1) this.groups.push([...this.selected]);
    this.report(`${this.groups.length} groups`);
  }

  ungroup() {
    this.groups = this.groups.filter((group) => !group.some((name) => this.selected.has(name)));
    this.report(`${this.groups.length} groups`);
  }

  toggleMirror() {
    if (this.drawing.is_mirrored === null) return;
    this.change((drawing) => (drawing.is_mirrored = !drawing.is_mirrored));
  }

  // ---- analysis and walk

  async #analyse(message) {
    try {
      const answer = await ask("analyse", message);
      // In the middle of a drag there is no time for the joints.
      const { links, masses } = this.analysis ?? {};
      this.analysis = { links, masses, ...answer };
      this.problems = [];
    } catch (error) {
      if (!(error instanceof Refusal)) throw error;
      this.problems = Object.keys(this.drawing.nodes).length ? error.problems : [];
      if (error.status !== 422) this.report(error.message, true);
    }
    this.#showAnalysis();
    if (!message.is_moving) this.posing.refresh();
    this.draw();
    if (message.is_moving) this.metrics.analysis.push(performance.now() - message.asked);
  }

  async #walk(message) {
    if (Object.keys(this.drawing.nodes).length < 2) return;
    try {
      const { bytes, facts } = await askBytes("walk", message);
      this.walked = facts;
      this.viewer.scale = facts.scale;
      await this.viewer.show(bytes);
      this.posing.refresh();
      this.bars.show(facts);
      this.walks = (this.walks ?? 0) + 1;
      this.showStance();
    } catch (error) {
      if (!(error instanceof Refusal)) throw error;
      if (error.status !== 409) this.showStance(error.message.split("\n")[0]);
    }
  }

  // Tells what the creature does.
  showStance(text = this.walked?.text ?? "") {
    document.getElementById("walk-text").textContent = this.posing.isOn ? "rest pose; Esc: walk on" : text;
  }

  #tick(now) {
    const duration = now - this.last;
    const seconds = Math.min(duration / 1000, 0.1);
    this.last = now;
    if (!document.getElementById("figure").hidden && this.walked && this.playing && !this.drag && !this.posing.isOn) {
      this.viewer.tookFrame(duration);
      this.seek((this.viewer.time + seconds) % this.walked.seconds);
    }
    requestAnimationFrame((next) => this.#tick(next));
  }

  seek(time) {
    if (this.posing.isOn) this.posing.select(null);
    this.viewer.seek(time);
    this.viewer.draw(true);
    this.bars.time = time;
    this.bars.draw();
  }

  #showAnalysis() {
    const { analysis, problems } = this;
    const head = document.getElementById("headline");
    const list = document.getElementById("warnings");
    const table = document.getElementById("limbs");
    const told = problems.length
      ? problems.map((one) => ({ node: one.node, text: `${one.path.replace(/^figures\.it\./, "")}: ${one.message}` }))
      : (analysis?.warnings ?? []);
    head.textContent = problems.length || !analysis ? "" : `${analysis.headline}${analysis.mass ? `, ${Number(analysis.mass.toPrecision(3))} kg` : ""}`;
    list.replaceChildren(
      ...told.map(({ node, text }) => {
        const item = document.createElement("li");
        item.textContent = `⚠ ${text}`;
        item.onclick = () => node in this.drawing.nodes && this.select([node]);
        return item;
      }),
    );
    if (this.drag) return;
    table.replaceChildren(...(analysis?.limbs ?? []).map((limb) => this.#limbRow(limb)));
  }

  #limbRow(limb) {
    const row = document.createElement("tr");
    const tip = limb.nodes[limb.nodes.length - 1];
    const choice = document.createElement("select");
    choice.setAttribute("aria-label", `what ${limb.name} is`);
    for (const kind of ["(guess)", ...this.document.kinds]) choice.append(new Option(kind));
    choice.value = this.drawing.parts[tip] ?? "(guess)";
    choice.onchange = () =>
      this.change((drawing) => {
        const tips = drawing.is_mirrored ? [tip, sheet.twinName(tip)] : [tip];
        for (const one of tips) {
          if (!this.analysis.nodes.some((node) => node.name === one)) continue;
          if (choice.value === "(guess)") delete drawing.parts[one];
          else drawing.parts[one] = choice.value;
        }
      });
    const cells = [
      Object.assign(document.createElement("span"), { className: "dot" }),
      `${limb.name}`,
      choice,
      Object.assign(document.createElement("span"), { className: "why", textContent: limb.kind === choice.value ? "" : `${limb.kind}: ${limb.reason}` }),
    ];
    cells[0].style.background = limb.color;
    for (const cell of cells) row.insertCell().append(cell);
    return row;
  }

  // ---- tools

  #buildTools() {
    const tools = document.getElementById("tools");
    const heading = (text) => tools.append(Object.assign(document.createElement("h2"), { textContent: text }));
    const row = () => {
      const box = Object.assign(document.createElement("div"), { className: "row" });
      tools.append(box);
      return box;
    };
    const button = (box, id, text, title, work) => {
      const one = Object.assign(document.createElement("button"), { id, textContent: text, title });
      one.onclick = () => {
        work();
        this.canvas.focus();
      };
      box.append(one);
    };
    const field = (text, input, title = "") => {
      const label = Object.assign(document.createElement("label"), { textContent: text, title });
      label.append(input);
      tools.append(label);
      return input;
    };
    const number = (id, value, step) =>
      Object.assign(document.createElement("input"), { id, type: "number", value, step });
    heading("Tool");
    let box = row();
    button(box, "tool-select", "Select", "V", () => this.#setTool("select"));
    button(box, "tool-draw", "Draw", "D: click for nodes and connections, Esc ends a line", () => this.#setTool("draw"));
    button(box, "lasso", "Lasso", "L: select inside an outline instead of a box", () => this.toggle("lasso"));
    button(box, "fit", "Fit", "F", () => this.fit());
    button(box, "see-text", "Text", "Y: the figure's text beside the drawing", () => this.toggleText());
    heading("Select");
    box = row();
    button(box, "all", "All", "Ctrl+A", () => this.select(Object.keys(this.drawing.nodes)));
    button(box, "none", "None", "Esc", () => this.select([]));
    button(box, "previous", "Previous", "P: the sets that were selected before", () => this.previousSet());
    button(box, "delete", "Delete", "Delete", () => this.deleteSelected());
    button(box, "group", "Group", "G: selected together from now on", () => this.group());
    button(box, "ungroup", "Ungroup", "Shift+G", () => this.ungroup());
    button(box, "connect", "Connect", "C", () => this.connectSelected(true));
    button(box, "disconnect", "Cut", "X", () => this.connectSelected(false));
    heading("Transform");
    box = row();
    button(box, "moves", "Move", "T: transformations move", () => this.set("copies", false));
    button(box, "copies", "Copy", "T: transformations copy", () => this.set("copies", true));
    button(box, "mirror-x", "Mirror X", "M", () => this.mirror(0));
    button(box, "mirror-y", "Mirror Y", "Shift+M", () => this.mirror(1));
    const about = document.createElement("select");
    about.id = "about-point";
    for (const text of ["centre", "origin"]) about.append(new Option(text));
    about.onchange = () => (this.about = about.value);
    field("about", about);
    const angle = field("angle °", number("angle", 15, 5), "[ and ] rotate by it");
    const [sx, sy] = [field("scale x", number("scale-x", 1.1, 0.1)), field("scale y", number("scale-y", 1.1, 0.1))];
    box = row();
    button(box, "rotate", "Rotate", "]", () => this.rotate(Number(angle.value)));
    button(box, "scale", "Scale", "+", () => this.scale(Number(sx.value), Number(sy.value)));
    const [dx, dy] = [field("by x", number("by-x", 0, 0.1)), field("by y", number("by-y", 0.2, 0.1))];
    box = row();
    button(box, "translate", "Translate", "arrow keys move", () => this.translate(Number(dx.value), Number(dy.value)));
    heading("Node");
    const named = field("name", Object.assign(document.createElement("input"), { id: "node-name", type: "text" }));
    const back = (input) => input.addEventListener("keydown", (event) => event.key === "Enter" && this.canvas.focus());
    named.onchange = () => this.#rename(named.value.trim());
    back(named);
    const radius = field("radius", number("node-radius", "", 0.01));
    radius.onchange = () => this.#setRadius(Number(radius.value));
    back(radius);
    heading("Figure");
    const style = document.createElement("select");
    style.id = "style";
    for (const text of ["insect", "mammal"]) style.append(new Option(text));
    style.onchange = () => this.change((drawing) => (drawing.settings.style = style.value));
    field("style", style);
    const feet = document.createElement("select");
    feet.id = "feet";
    for (const text of ["(usual)", "plain", "claws", "hooves", "paws", "toes"]) feet.append(new Option(text));
    feet.onchange = () =>
      this.change((drawing) => {
        if (feet.value === "(usual)") delete drawing.settings.feet;
        else drawing.settings.feet = feet.value;
      });
    field("feet", feet);
    box = row();
    button(box, "mirrored", "Mirrored", "B: the other half is drawn by itself", () => this.toggleMirror());
    button(box, "snaps", "Snap", "S: to axes and grid", () => this.toggle("snaps"));
    const grid = field("grid m", number("grid", this.grid, 0.01));
    grid.onchange = () => this.set("grid", Math.max(Number(grid.value) || 0.05, 0.001));
    heading("Picture behind");
    box = row();
    button(box, "choose-picture", "Choose", "a picture under the drawing; it may be dropped there too", () => this.backdrop.choose());
    button(box, "move-picture", "Move", "I: drag the picture, scale it by the wheel, turn it by Shift and the wheel", () => this.backdrop.toggle());
    this.pictureFields = new Map();
    for (const [key, text, step] of this.backdrop.fields) {
      const input = field(text, number(`picture-${key}`, "", step));
      input.onchange = () => this.backdrop.set(key, Number(input.value));
      back(input);
      this.pictureFields.set(key, input);
    }
    this.fields = { named, radius, style, feet };
  }

  toggle(key) {
    this.set(key, !this[key]);
  }

  set(key, value) {
    this[key] = value;
    this.refresh();
  }

  refresh() {
    this.#refreshTools();
    this.draw();
  }

  #setTool(tool) {
    this.tool = tool;
    this.loose = null;
    this.#refreshTools();
    this.draw();
  }

  #refreshTools() {
    const on = (id, value) => document.getElementById(id).classList.toggle("on", Boolean(value));
    on("tool-select", this.tool === "select");
    on("tool-draw", this.tool === "draw");
    on("lasso", this.lasso);
    on("copies", this.copies);
    on("moves", !this.copies);
    on("snaps", this.snaps);
    on("mirrored", this.drawing?.is_mirrored);
    document.getElementById("mirrored").disabled = this.drawing?.is_mirrored === null;
    const [one] = this.selected ?? [];
    const single = this.selected?.size === 1 ? this.drawing.nodes[one] : null;
    this.fields.named.value = single ? one : "";
    this.fields.named.disabled = !single;
    this.fields.radius.value = single?.radius ?? "";
    this.fields.style.value = this.drawing?.settings.style ?? "insect";
    this.fields.feet.value = this.drawing?.settings.feet ?? "(usual)";
    document.getElementById("undo").disabled = this.isLocked || !this.undos?.length;
    document.getElementById("redo").disabled = this.isLocked || !this.redos?.length;
    on("see-text", this.text?.isShown);
    on("move-picture", this.backdrop.isMoved);
    for (const [key, input] of this.pictureFields) {
      input.value = this.backdrop.current?.[key] ?? "";
      input.disabled = !this.backdrop.current;
    }
    this.onChange?.();
  }

  #rename(name) {
    const [before] = this.selected;
    if (!/^[\p{L}\p{N}_][\p{L}\p{N}_ -]*$/u.test(name) || name in this.drawing.nodes) return this.#refreshTools();
    this.change((drawing) => sheet.rename(drawing, before, name));
    this.select([name]);
  }

  #setRadius(value) {
    if (!(value > 0) || !this.selected.size) return this.#refreshTools();
    this.change((drawing) => this.selected.forEach((name) => (drawing.nodes[name].radius = value)));
  }

  async toggleText() {
    await this.text.show(!this.text.isShown);
    this.#refreshTools();
    this.fit();
  }

  // ---- mouse and keyboard

  toSheet(event) {
    const box = this.canvas.getBoundingClientRect();
    const { x, y, scale } = this.view;
    return [
      (event.clientX - box.left - box.width / 2) / scale + x,
      (event.clientY - box.top - box.height / 2) / scale + y,
    ];
  }

  toScreen([x, y]) {
    const { clientWidth, clientHeight } = this.canvas;
    return [
      (x - this.view.x) * this.view.scale + clientWidth / 2,
      (y - this.view.y) * this.view.scale + clientHeight / 2,
    ];
  }

  snapped([x, y]) {
    if (!this.snaps) return [x, y];
    const sticky = STICKY / this.view.scale;
    return [x, y].map((value) => {
      if (Math.abs(value) < sticky) return 0;
      const line = Math.round(value / this.grid) * this.grid;
      return Number((Math.abs(value - line) < sticky ? line : value).toFixed(4));
    });
  }

  // The drawn nodes and, where the figure is mirrored, their twins: name, place, side.
  *shown() {
    for (const [name, node] of Object.entries(this.drawing.nodes)) {
      yield { name, source: name, at: node.at, radius: this.radiusOf(name), side: 1 };
      if (this.drawing.is_mirrored && node.at[0] !== 0) {
        const at = [-node.at[0], node.at[1]];
        yield { name: sheet.twinName(name), source: name, at, radius: this.radiusOf(name), side: -1 };
      }
    }
  }

  radiusOf(name) {
    const own = this.drawing.nodes[name].radius;
    return own ?? this.analysis?.nodes.find((node) => node.name === name)?.radius ?? 0.03;
  }

  hit(event) {
    const [x, y] = this.toSheet(event);
    let best = null;
    for (const node of this.shown()) {
      const distance = Math.hypot(node.at[0] - x, node.at[1] - y) * this.view.scale;
      if (distance < STICKY + 3 && (!best || distance < best.distance)) best = { ...node, distance };
    }
    return best;
  }

  hitHandle(event) {
    const [x, y] = this.toSheet(event);
    for (const name of this.selected) {
      const { at } = this.drawing.nodes[name];
      const away = Math.hypot(at[0] + this.radiusOf(name) - x, at[1] - y) * this.view.scale;
      if (away < STICKY) return name;
    }
    return null;
  }

  hitEdge(event) {
    const [x, y] = this.toSheet(event);
    for (const [a, b] of sheet.pairs(this.drawing)) {
      const [[ax, ay], [bx, by]] = [this.drawing.nodes[a]?.at ?? [NaN, 0], this.drawing.nodes[b]?.at ?? [NaN, 0]];
      const length = (bx - ax) ** 2 + (by - ay) ** 2;
      const t = Math.min(Math.max(((x - ax) * (bx - ax) + (y - ay) * (by - ay)) / length, 0), 1);
      if (Math.hypot(ax + t * (bx - ax) - x, ay + t * (by - ay) - y) * this.view.scale < 6) return [a, b];
    }
    return null;
  }

  #listen() {
    const { canvas } = this;
    canvas.addEventListener("pointerdown", (event) => this.#down(event));
    canvas.addEventListener("pointermove", (event) => this.#move(event));
    canvas.addEventListener("pointerup", (event) => this.#up(event));
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      const [x, y] = this.toSheet(event);
      const factor = Math.exp(-(event.deltaY || event.deltaX) * 0.0015);
      if (this.backdrop.isMoved) return this.backdrop.wheel([x, y], factor, event.shiftKey);
      this.view.scale = Math.min(Math.max(this.view.scale * factor, 2), 20000);
      const [nx, ny] = this.toSheet(event);
      this.view.x += x - nx;
      this.view.y += y - ny;
      this.draw();
    }, { passive: false });
    window.addEventListener("keydown", (event) => this.#key(event));
  }

  #down(event) {
    this.canvas.focus();
    this.canvas.setPointerCapture(event.pointerId);
    const place = this.toSheet(event);
    const node = this.hit(event);
    if (event.button === 1) {
      // A click draws or deletes (Sims 1987, A.1), a drag moves the board.
      event.preventDefault();
      const [x, y] = [event.clientX, event.clientY];
      this.drag = { kind: "pan", x, y, start: [x, y], click: () => this.#middleAt(place, node) };
      return;
    }
    if (event.button === 2) {
      if (this.loose) {
        this.loose = null;
        return this.draw();
      }
      this.drag = { kind: "pan", x: event.clientX, y: event.clientY };
      return;
    }
    if (this.backdrop.isMoved) {
      this.drag = { kind: "picture", last: place };
      return;
    }
    if (this.tool === "draw") return this.#drawAt(place, node);
    const handle = this.hitHandle(event);
    if (handle && !(node && node.distance < 4)) {
      this.drag = { kind: "radius", name: handle, before: JSON.stringify(this.drawing) };
    } else if (node) {
      if (event.shiftKey) return this.#toggleNode(node.source);
      if (!this.selected.has(node.source)) this.select([node.source]);
      this.drag = {
        kind: "nodes",
        side: node.side,
        grabbed: node.source,
        from: [...place],
        at: Object.fromEntries([...this.selected].map((name) => [name, [...this.drawing.nodes[name].at]])),
        before: JSON.stringify(this.drawing),
      };
    } else {
      const edge = this.hitEdge(event);
      if (edge) {
        this.select([]);
        this.edge = edge;
        return this.draw();
      }
      this.drag = { kind: "area", keeps: event.shiftKey, points: [place], outline: this.lasso };
    }
  }

  #middleAt(place, node) {
    if (this.loose) {
      this.#drawAt(place, node);
      this.loose = null;
    } else if (node?.side > 0) this.change((drawing) => sheet.remove(drawing, [node.name]));
    else if (!node) this.#create(this.snapped(place));
    this.draw();
  }

  #toggleNode(name) {
    if (!this.selected.has(name)) return this.select([name], true);
    this.select([...this.selected].filter((one) => one !== name));
  }

  #drawAt(place, node) {
    if (node?.side < 0) return;
    const at = this.snapped(place);
    const from = this.loose;
    if (node) {
      if (from && from !== node.name) this.change((drawing) => sheet.connect(drawing, from, node.name));
      this.loose = from ? null : node.name;
      return this.draw();
    }
    this.loose = this.#create(at, from);
    this.draw();
  }

  // Makes a node, connected with another where one is given, and selects it.
  #create(at, from = null) {
    let made = null;
    this.change((drawing) => {
      made = sheet.create(drawing, at, (from && drawing.nodes[from].radius) || NEW_RADIUS);
      if (from) sheet.connect(drawing, from, made);
    });
    this.select([made]);
    return made;
  }

  // By the keyboard: a node beside the one that is selected, connected with it.
  createBeside() {
    const from = this.selected.size === 1 ? [...this.selected][0] : null;
    const [x, y] = from ? this.drawing.nodes[from].at : [0, 0];
    this.#create(this.snapped(from ? [x, y + BESIDE] : [x, y]), from);
  }

  // Selects the next node of the drawing, or the one before.
  selectNext(step) {
    const names = Object.keys(this.drawing.nodes);
    if (!names.length) return;
    const at = names.indexOf([...this.selected].pop());
    const next = at < 0 ? (step > 0 ? 0 : -1) : at + step;
    this.select([names.at(next % names.length)]);
  }

  scaleRadii(factor) {
    if (!this.selected.size) return;
    const sizes = [...this.selected].map((name) => [name, Number((this.radiusOf(name) * factor).toFixed(4))]);
    this.change((drawing) => sizes.forEach(([name, size]) => (drawing.nodes[name].radius = size)));
  }

  #move(event) {
    this.pointer = this.toSheet(event);
    const { drag } = this;
    if (!drag) {
      const over = this.hit(event);
      if (over?.name !== this.over?.name || this.loose) {
        this.over = over;
        this.draw();
      }
      return;
    }
    const [x, y] = this.pointer;
    if (drag.kind === "pan") {
      this.view.x -= (event.clientX - drag.x) / this.view.scale;
      this.view.y -= (event.clientY - drag.y) / this.view.scale;
      Object.assign(drag, { x: event.clientX, y: event.clientY });
      if (drag.click && Math.hypot(drag.x - drag.start[0], drag.y - drag.start[1]) > CLICK) drag.click = null;
    } else if (drag.kind === "picture") {
      this.backdrop.move(x - drag.last[0], y - drag.last[1]);
      drag.last = [x, y];
    } else if (drag.kind === "area") {
      if (drag.outline) drag.points.push([x, y]);
      else drag.points[1] = [x, y];
    } else if (drag.kind === "radius") {
      const node = this.drawing.nodes[drag.name];
      node.radius = Number(Math.max(Math.hypot(x - node.at[0], y - node.at[1]), 0.002).toFixed(4));
    } else {
      const start = drag.at[drag.grabbed];
      const wished = this.snapped([start[0] + drag.side * (x - drag.from[0]), start[1] + y - drag.from[1]]);
      const [dx, dy] = [wished[0] - start[0], wished[1] - start[1]];
      for (const [name, at] of Object.entries(drag.at)) {
        this.drawing.nodes[name].at = [Number((at[0] + dx).toFixed(4)), Number((at[1] + dy).toFixed(4))];
      }
    }
    this.draw();
    if (drag.kind === "nodes" || drag.kind === "radius") {
      this.metrics.drawing.push(performance.now() - event.timeStamp);
      this.analyse(this.#message());
    }
  }

  #up() {
    const { drag } = this;
    this.drag = null;
    if (!drag) return;
    if (drag.click) return drag.click();
    if (drag.before && drag.before !== JSON.stringify(this.drawing)) {
      this.commit(drag.before);
    } else if (drag.kind === "area") {
      const [[ax, ay], last] = [drag.points[0], drag.points[drag.points.length - 1]];
      const [bx, by] = last;
      const inside = drag.outline
        ? (at) => sheet.isInside(at, drag.points)
        : ([x, y]) => x >= Math.min(ax, bx) && x <= Math.max(ax, bx) && y >= Math.min(ay, by) && y <= Math.max(ay, by);
      const names = Object.keys(this.drawing.nodes).filter((name) => inside(this.drawing.nodes[name].at));
      this.select(names, drag.keeps);
    }
    this.draw();
  }

  #key(event) {
    if (document.getElementById("figure").hidden || this.isLocked) return;
    if (/INPUT|SELECT|TEXTAREA/.test(event.target.tagName) || event.target.closest(".cm-editor")) return;
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    const held = event.ctrlKey || event.metaKey;
    const step = event.shiftKey ? 0.1 : 0.01;
    const angle = Number(document.getElementById("angle").value);
    const plain = {
      v: () => this.#setTool("select"),
      d: () => this.#setTool("draw"),
      l: () => this.toggle("lasso"),
      n: () => this.createBeside(),
      ",": () => this.selectNext(-1),
      ".": () => this.selectNext(1),
      e: () => this.scaleRadii(event.shiftKey ? 1 / 1.1 : 1.1),
      f: () => this.fit(),
      p: () => this.previousSet(),
      g: () => (event.shiftKey ? this.ungroup() : this.group()),
      c: () => this.connectSelected(true),
      x: () => this.connectSelected(false),
      t: () => this.toggle("copies"),
      m: () => this.mirror(event.shiftKey ? 1 : 0),
      b: () => this.toggleMirror(),
      s: () => this.toggle("snaps"),
      y: () => this.toggleText(),
      i: () => this.backdrop.toggle(),
      "[": () => this.rotate(-angle),
      "]": () => this.rotate(angle),
      "+": () => this.scale(1.1),
      "-": () => this.scale(1 / 1.1),
      " ": () => (this.posing.isOn ? this.posing.select(null) : (this.playing = !this.playing)),
      Delete: () => this.deleteSelected(),
      Backspace: () => this.deleteSelected(),
      Escape: () => {
        if (this.loose) this.set("loose", null);
        else if (this.backdrop.isMoved) this.backdrop.toggle();
        else if (this.posing.isOn) this.posing.select(null);
        else this.select([]);
      },
      ArrowLeft: () => this.translate(-step, 0, false),
      ArrowRight: () => this.translate(step, 0, false),
      ArrowUp: () => this.translate(0, -step, false),
      ArrowDown: () => this.translate(0, step, false),
    };
    const withControl = {
      a: () => this.select(Object.keys(this.drawing.nodes)),
      z: () => (event.shiftKey ? this.redo() : this.undo()),
      y: () => this.redo(),
      d: () => this.transform(([x, y]) => [x + this.grid * 2, y + this.grid * 2], 1, true),
      g: () => this.group(),
    };
    const work = (held ? withControl : plain)[key];
    if (!work) return;
    event.preventDefault();
    work();
  }

  fit() {
    const places = this.drawing ? [...this.shown()] : [];
    const { clientWidth, clientHeight } = this.canvas;
    if (places.length < 2 || !clientWidth) {
      this.view = { x: 0, y: 0, scale: 180 };
      return this.draw();
    }
    const [xs, ys] = [places.map((node) => node.at[0]), places.map((node) => node.at[1])];
    const [x0, x1, y0, y1] = [Math.min(...xs), Math.max(...xs), Math.min(...ys), Math.max(...ys)];
    const [wide, high] = [clientWidth - Math.min(130, clientWidth / 5), clientHeight - 110];
    const scale = Math.min(wide / Math.max(x1 - x0, 0.1), high / Math.max(y1 - y0, 0.1));
    this.view = { x: (x0 + x1) / 2, y: (y0 + y1) / 2, scale: Math.min(scale, 2000) };
    this.draw();
  }

  // ---- drawing

  draw() {
    const { canvas, context } = this;
    const { clientWidth: width, clientHeight: height } = canvas;
    if (!width || !this.drawing) return;
    const ratio = devicePixelRatio;
    if (canvas.width !== width * ratio || canvas.height !== height * ratio) {
      canvas.width = width * ratio;
      canvas.height = height * ratio;
    }
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, width, height);
    this.#drawPaper(width, height);
    if (Object.keys(this.drawing.nodes).length) this.#drawFigure();
    else this.#drawHint(width, height);
    this.#drawArea();
  }

  #drawPaper(width, height) {
    const { context, view } = this;
    this.backdrop.draw(context, view.scale, (place) => this.toScreen(place));
    let spacing = this.grid;
    while (spacing * view.scale < 12) spacing *= spacing.toString().includes("5") ? 2 : 5;
    context.fillStyle = "#cfcabe";
    const [x0, y0] = [view.x - width / 2 / view.scale, view.y - height / 2 / view.scale];
    for (let x = Math.ceil(x0 / spacing) * spacing; x < x0 + width / view.scale; x += spacing) {
      for (let y = Math.ceil(y0 / spacing) * spacing; y < y0 + height / view.scale; y += spacing) {
        const [sx, sy] = this.toScreen([x, y]);
        context.fillRect(sx - 0.5, sy - 0.5, 1, 1);
      }
    }
    const [ox, oy] = this.toScreen([0, 0]);
    context.strokeStyle = FAINT;
    context.setLineDash([2, 5]);
    context.beginPath();
    context.moveTo(ox, 0);
    context.lineTo(ox, height);
    context.moveTo(0, oy);
    context.lineTo(width, oy);
    context.stroke();
    context.setLineDash([]);
    context.fillStyle = FAINT;
    context.font = "12px system-ui";
    context.fillText("head ↑", ox + 6, 16);
    context.fillText("tail ↓", ox + 6, height - 8);
    const metre = [1, 0.5, 0.2, 0.1, 0.05, 0.01].find((one) => one * view.scale < width / 4) ?? 0.01;
    context.fillRect(14, height - 16, metre * view.scale, 2);
    context.fillText(`${metre} m`, 14, height - 22);
  }

  #drawHint(width, height) {
    const text = this.isLocked ? "the text is no figure yet" : "Draw (D): click for nodes and connections; Esc ends a line";
    this.context.fillStyle = FAINT;
    this.context.textAlign = "center";
    this.context.fillText(text, width / 2, height / 2 - 14);
    this.context.textAlign = "left";
  }

  #drawFigure() {
    const { context, view, analysis } = this;
    const colors = new Map((analysis?.nodes ?? []).map((node) => [node.name, node.color]));
    const lines = new Map((analysis?.connections ?? []).map(([a, b, color]) => [[a, b].sort().join("\n"), color]));
    const nodes = [...this.shown()];
    const places = new Map(nodes.map((node) => [node.name, this.toScreen(node.at)]));
    // What other operations have made stands where it was analysed.
    if (this.drawing.is_mirrored === null) {
      for (const node of analysis?.nodes ?? []) if (!places.has(node.name)) places.set(node.name, this.toScreen(node.at));
    }
    for (const { name, radius, side } of nodes) {
      const [x, y] = places.get(name);
      context.globalAlpha = side > 0 ? 0.16 : 0.09;
      context.fillStyle = colors.get(name) ?? FAINT;
      context.beginPath();
      context.arc(x, y, radius * view.scale, 0, 2 * Math.PI);
      context.fill();
    }
    context.globalAlpha = 1;
    const line = (a, b, color, lineWidth) => {
      if (!places.has(a) || !places.has(b)) return;
      context.strokeStyle = color;
      context.lineWidth = lineWidth;
      context.lineCap = "round";
      context.beginPath();
      context.moveTo(...places.get(a));
      context.lineTo(...places.get(b));
      context.stroke();
    };
    if (this.drawing.is_mirrored === null) for (const [a, b, color] of analysis?.connections ?? []) line(a, b, color, 3);
    for (const [a, b] of sheet.pairs(this.drawing)) {
      const color = lines.get([a, b].sort().join("\n")) ?? FAINT;
      line(a, b, color, 4);
      if (this.drawing.is_mirrored) {
        const twin = (name) => (this.drawing.nodes[name]?.at[0] === 0 ? name : sheet.twinName(name));
        const other = lines.get([twin(a), twin(b)].sort().join("\n")) ?? color;
        context.globalAlpha = 0.5;
        if (twin(a) !== a || twin(b) !== b) line(twin(a), twin(b), other, 4);
        context.globalAlpha = 1;
      }
      if (this.edge && this.edge.includes(a) && this.edge.includes(b)) line(a, b, ACCENT, 7);
      if (this.selected.has(a) && this.selected.has(b)) line(a, b, ACCENT, 2);
    }
    if (this.loose && this.pointer) {
      places.set("\0", this.toScreen(this.snapped(this.pointer)));
      context.setLineDash([5, 5]);
      line(this.loose, "\0", ACCENT, 2);
      context.setLineDash([]);
    }
    for (const node of nodes) this.#drawNode(node, places.get(node.name), colors.get(node.name) ?? BODY);
    this.#drawWarnings(places);
  }

  #drawNode({ name, source, radius, side }, [x, y], color) {
    const { context } = this;
    const isSelected = this.selected.has(source);
    context.globalAlpha = side > 0 ? 1 : 0.55;
    context.fillStyle = isSelected && side > 0 ? ACCENT : "#fff";
    context.strokeStyle = color;
    context.lineWidth = 3;
    context.beginPath();
    context.arc(x, y, this.over?.name === name ? 7 : 5, 0, 2 * Math.PI);
    context.fill();
    context.stroke();
    context.globalAlpha = 1;
    if (isSelected && side > 0) {
      const edge = x + radius * this.view.scale;
      context.strokeStyle = ACCENT;
      context.lineWidth = 1;
      context.beginPath();
      context.arc(x, y, radius * this.view.scale, 0, 2 * Math.PI);
      context.stroke();
      context.fillStyle = ACCENT;
      context.fillRect(edge - 4, y - 4, 8, 8);
    }
    if ((isSelected && side > 0) || this.over?.name === name || this.loose === name) {
      context.fillStyle = INK;
      context.font = "12px system-ui";
      context.fillText(name, x + 9, y - 9);
    }
  }

  #drawWarnings(places) {
    const told = this.problems?.length ? this.problems : (this.analysis?.warnings ?? []);
    this.context.fillStyle = WARNING;
    this.context.font = "bold 17px system-ui";
    for (const { node } of told) {
      const place = places.get(node);
      if (place) this.context.fillText("⚠", place[0] - 20, place[1] + 6);
    }
  }

  #drawArea() {
    const { context, drag } = this;
    if (drag?.kind !== "area" || drag.points.length < 2) return;
    const [first, ...others] = drag.outline
      ? drag.points
      : [drag.points[0], [drag.points[1][0], drag.points[0][1]], drag.points[1], [drag.points[0][0], drag.points[1][1]]];
    context.beginPath();
    context.moveTo(...this.toScreen(first));
    for (const point of others) context.lineTo(...this.toScreen(point));
    context.closePath();
    context.fillStyle = "#2d6fb41c";
    context.strokeStyle = ACCENT;
    context.lineWidth = 1;
    context.fill();
    context.stroke();
  }
}
