// A picture behind the drawing, such as a photograph of a skeleton: moved, scaled and turned to fit.

const WIDTH = 2; // m, at first
const OPACITY = 0.45;
const NOTCH = 1; // degrees that a step of the wheel turns

const tidy = (value) => Number(value.toFixed(4));

export class Backdrop {
  // Pictures stay with the figures they were chosen for as long as the page is open.
  constructor(canvas, report, changed) {
    this.report = report;
    this.changed = changed;
    this.placed = new Map();
    this.current = null;
    this.isMoved = false;
    this.input = Object.assign(document.createElement("input"), { id: "picture", type: "file", accept: "image/*", hidden: true });
    this.input.onchange = () => this.input.files.length && this.#show(this.input.files[0]);
    canvas.after(this.input);
    canvas.addEventListener("dragover", (event) => event.preventDefault());
    canvas.addEventListener("drop", (event) => {
      event.preventDefault();
      if (event.dataTransfer.files.length) this.#show(event.dataTransfer.files[0]);
    });
  }

  // Name, label and step of what can be typed: the middle and width [m] and the turn clockwise [degrees].
  get fields() {
    return [["width", "width m", 0.1], ["x", "at x", 0.05], ["y", "at y", 0.05], ["turn", "turn °", 1]];
  }

  // Shows the picture of a document.
  open(name) {
    this.name = name;
    this.current = this.placed.get(name) ?? null;
    this.isMoved = false;
  }

  // The picture belongs to a document that has got a name.
  keep(name) {
    this.name = name;
    if (this.current) this.placed.set(name, this.current);
  }

  choose() {
    this.input.value = "";
    this.input.click();
  }

  async #show(file) {
    try {
      const image = await createImageBitmap(file);
      const { width, x, y, turn } = this.current ?? { width: WIDTH, x: 0, y: 0, turn: 0 };
      this.current = { image, width, x, y, turn };
      this.keep(this.name);
      this.report(`${file.name}: behind the drawing`);
    } catch {
      this.report(`${file.name} is no picture that this browser reads`, true);
    }
    this.changed();
  }

  toggle() {
    if (!this.current && !this.isMoved) return this.report("choose a picture first", true);
    this.isMoved = !this.isMoved;
    this.changed();
  }

  set(key, value) {
    if (this.current && Number.isFinite(value)) this.current[key] = key === "width" ? Math.max(value, 0.01) : value;
    this.changed();
  }

  move(dx, dy) {
    this.current.x = tidy(this.current.x + dx);
    this.current.y = tidy(this.current.y + dy);
    this.changed();
  }

  // Scales about a place of the drawing, or turns about it.
  wheel([px, py], factor, turns) {
    const { current } = this;
    const step = turns ? -Math.sign(Math.log(factor)) * NOTCH : 0;
    const [c, s] = [Math.cos((step * Math.PI) / 180), Math.sin((step * Math.PI) / 180)];
    const size = turns ? 1 : factor;
    const [dx, dy] = [(current.x - px) * size, (current.y - py) * size];
    current.x = tidy(px + c * dx - s * dy);
    current.y = tidy(py + s * dx + c * dy);
    current.width = tidy(Math.max(current.width * size, 0.01));
    current.turn = ((((current.turn + step + 180) % 360) + 360) % 360) - 180;
    this.changed();
  }

  draw(context, scale, toScreen) {
    if (!this.current) return;
    const { image, width, x, y, turn } = this.current;
    const [w, h] = [width * scale, (width * scale * image.height) / image.width];
    context.save();
    context.globalAlpha = OPACITY;
    context.translate(...toScreen([x, y]));
    context.rotate((turn * Math.PI) / 180);
    context.drawImage(image, -w / 2, -h / 2, w, h);
    context.restore();
  }
}
