// The map: the scene seen from above, with the positions that its text gives, to be dragged.

import { Vector3 } from "three";
import { numberLists } from "./text_tree.js";

const KEYS = new Set(["at", "path", "go_to", "to", "land_at", "reach", "flee", "position", "target"]);
const NEAR = 10; // pixels within which a position is taken
const LEAST = 3; // metres seen on both sides of the middle, at least

// The positions that a text gives: lists [x, z] or [x, y, z] in metres, those of what is carried
// relative to `carrier`.
export function positionsOf(text, plain) {
  return numberLists(text).flatMap((list) => {
    const { path, numbers } = list;
    if (numbers.length !== 2 && numbers.length !== 3) return [];
    const [block, k] = path;
    const key = path.findLast((step) => typeof step === "string");
    const isPlace = block === "places" && path.length === 2;
    if (!isPlace && !(KEYS.has(key) && ["cast", "script", "camera", "terrain"].includes(block))) return [];
    const owner = typeof k === "number" ? plain?.[block]?.[k] : plain?.[block];
    // Drums are placed by their dance, and plants by their species.
    if (path.includes("drums") || path.includes("scatter")) return [];
    const carrier = block === "cast" ? (owner?.parent ?? null) : null;
    if (block === "terrain" && numbers.length !== 2) return [];
    const label = isPlace ? k : `${owner?.name ?? owner?.who ?? block} ${key}`;
    const line = typeof path.at(-1) === "number" ? path.slice(0, -1).join(".") : null;
    const height = numbers.length === 3 ? numbers[1].value : 0;
    return [{ ...list, label, line, carrier, height, x: numbers[0].value, z: numbers.at(-1).value }];
  });
}

// The own x and z of a point that is seen at a place of the world, at the height that it has on what
// carries it.
function carried({ x, z, own, pose }, toX, toZ) {
  const [a, , c] = pose.elements;
  const [b, , d] = pose.elements.slice(8);
  const turned = a * d - b * c;
  // Seen along its plane there is nothing to choose from.
  if (Math.abs(turned) < 0.05) return own;
  const [dx, dz] = [toX - x, toZ - z];
  return { x: own.x + (d * dx - b * dz) / turned, z: own.z + (a * dz - c * dx) / turned };
}

export class TerrainMap {
  constructor(canvas, viewer, editor) {
    Object.assign(this, { canvas, viewer, editor, isShown: false, forbidden: null, carriers: null });
    canvas.addEventListener("pointerdown", (event) => this.#press(event));
    canvas.addEventListener("pointermove", (event) => this.#move(event));
    canvas.addEventListener("pointerup", () => this.#release());
    canvas.addEventListener("wheel", (event) => this.#zoom(event), { passive: false });
    new ResizeObserver(() => this.draw()).observe(canvas.parentElement);
  }

  show(isShown) {
    this.isShown = isShown;
    this.canvas.hidden = !isShown;
    if (isShown) this.#fit();
    else this.viewer.seeFromAbove(null);
    this.draw();
  }

  // Where they are in the world at this moment; what nothing carries yet is left out.
  get points() {
    const text = this.editor.viewText;
    if (text !== this.read?.text) this.read = { text, points: positionsOf(text, this.editor.plain) };
    return this.read.points.flatMap((point) => {
      if (!point.carrier) return [point];
      const pose = this.viewer.poseOf(this.carriers?.[point.carrier]);
      if (!pose) return [];
      const { x, z } = new Vector3(point.x, point.height, point.z).applyMatrix4(pose);
      return [{ ...point, x, z, own: { x: point.x, z: point.z }, pose: pose.clone() }];
    });
  }

  #fit() {
    const performers = this.viewer.bounds();
    const points = this.points;
    const xs = [...points.map(({ x }) => x), ...(performers.isEmpty() ? [] : [performers.min.x, performers.max.x])];
    const zs = [...points.map(({ z }) => z), ...(performers.isEmpty() ? [] : [performers.min.z, performers.max.z])];
    const [left, right] = xs.length ? [Math.min(...xs), Math.max(...xs)] : [0, 0];
    const [top, bottom] = zs.length ? [Math.min(...zs), Math.max(...zs)] : [0, 0];
    const { clientWidth: width, clientHeight: height } = this.canvas.parentElement;
    const half = Math.max((bottom - top) / 2, ((right - left) / 2) * (height / width), LEAST) * 1.25;
    this.view = { x: (left + right) / 2, z: (top + bottom) / 2, half };
  }

  get #scale() {
    return this.canvas.parentElement.clientHeight / (2 * this.view.half);
  }

  toScreen(x, z) {
    const { clientWidth: width, clientHeight: height } = this.canvas.parentElement;
    return [width / 2 + (x - this.view.x) * this.#scale, height / 2 + (z - this.view.z) * this.#scale];
  }

  #metres(event) {
    const box = this.canvas.getBoundingClientRect();
    return [
      this.view.x + (event.clientX - box.left - box.width / 2) / this.#scale,
      this.view.z + (event.clientY - box.top - box.height / 2) / this.#scale,
    ];
  }

  #press(event) {
    this.canvas.setPointerCapture(event.pointerId);
    const [x, z] = this.#metres(event);
    const near = this.points
      .map((point) => [Math.hypot(point.x - x, point.z - z) * this.#scale, point])
      .sort((a, b) => a[0] - b[0])[0];
    if (!near || near[0] > NEAR) {
      this.pan = { x, z };
      return;
    }
    const [, point] = near;
    const text = this.editor.viewText;
    this.held = { point, draft: this.editor.draft(point.from, point.to), text };
  }

  #move(event) {
    const [x, z] = this.#metres(event);
    if (this.pan) {
      this.view.x += this.pan.x - x;
      this.view.z += this.pan.z - z;
      this.draw();
    } else if (this.held) {
      const { point, draft, text } = this.held;
      const [first, last] = [point.numbers[0], point.numbers.at(-1)];
      const written = (value) => String(Number(value.toFixed(2)));
      const own = point.pose ? carried(point, x, z) : { x, z };
      draft.write(text.slice(point.from, first.from) + written(own.x) + text.slice(first.to, last.from) + written(own.z) + text.slice(last.to, point.to));
      this.draw();
    }
  }

  #release() {
    this.held?.draft.end();
    this.held = this.pan = null;
    this.draw();
  }

  #zoom(event) {
    event.preventDefault();
    const [x, z] = this.#metres(event);
    const factor = 1.0015 ** event.deltaY;
    this.view = { x: x + (this.view.x - x) * factor, z: z + (this.view.z - z) * factor, half: this.view.half * factor };
    this.draw();
  }

  draw(isMoving = false) {
    if (!this.isShown) return;
    this.viewer.seeFromAbove(this.view, isMoving);
    const { clientWidth: width, clientHeight: height } = this.canvas.parentElement;
    this.canvas.width = width * devicePixelRatio;
    this.canvas.height = height * devicePixelRatio;
    const context = this.canvas.getContext("2d");
    context.scale(devicePixelRatio, devicePixelRatio);
    this.#drawForbidden(context);
    const lines = new Map();
    for (const point of this.points) {
      const [x, y] = this.toScreen(point.x, point.z);
      if (point.line) lines.set(point.line, [...(lines.get(point.line) ?? []), [x, y]]);
      context.fillStyle = "#fff";
      context.strokeStyle = point.carrier ? "#b8862b" : "#2d6fb4";
      context.lineWidth = 2.5;
      context.beginPath();
      context.arc(x, y, 6, 0, 2 * Math.PI);
      context.fill();
      context.stroke();
      context.font = "12px system-ui";
      context.lineWidth = 3;
      context.strokeStyle = "#fffc";
      context.strokeText(point.label, x + 10, y + 4);
      context.fillStyle = "#1f2933";
      context.fillText(point.label, x + 10, y + 4);
    }
    context.strokeStyle = "#2d6fb4";
    context.lineWidth = 1.5;
    for (const line of lines.values()) {
      context.beginPath();
      for (const [x, y] of line) context.lineTo(x, y);
      context.stroke();
    }
  }

  // Where no foot may be put.
  #drawForbidden(context) {
    if (!this.forbidden) return;
    const { corner, cell, runs } = this.forbidden;
    context.fillStyle = "#b4442f66";
    for (const [row, start, end] of runs) {
      const [x, y] = this.toScreen(corner[0] + start * cell[0], corner[1] + row * cell[1]);
      context.fillRect(x, y, (end - start) * cell[0] * this.#scale, cell[1] * this.#scale + 0.5);
    }
  }
}
