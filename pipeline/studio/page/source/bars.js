// Bars over time: stances of feet, marks of sound events, channels, and the present moment.

const INK = "#1f2933";
const FAINT = "#8a94a0";
const COLORS = ["#2d6fb4", "#b4442f", "#3f8f5f", "#8a5fb0", "#b8862b", "#3a9aa5"];
const STRIP = 15; // pixels of a row of names
const CURVE = 34; // pixels of a curve

export class Bars {
  constructor(canvas, seek, pick) {
    this.canvas = canvas;
    this.seconds = this.known = 1;
    this.gait = [];
    this.events = [];
    this.curves = [];
    this.strips = [];
    this.time = 0;
    this.left = 110;
    // The sound event whose mark is at the mouse.
    const markAt = (event) => {
      const box = canvas.getBoundingClientRect();
      if (event.clientY - box.top >= 16) return null;
      const time = at(event);
      const [near] = this.events
        .map((sound) => [Math.abs(sound.time - time), sound])
        .sort((a, b) => a[0] - b[0]);
      return near && near[0] < this.seconds / 60 ? near[1] : null;
    };
    const at = (event) => {
      const box = canvas.getBoundingClientRect();
      return ((event.clientX - box.left - this.left) / (box.width - this.left - 8)) * this.seconds;
    };
    canvas.addEventListener("pointerdown", (event) => {
      const mark = pick && markAt(event);
      if (mark) return pick(mark);
      canvas.setPointerCapture(event.pointerId);
      this.isHeld = true;
      seek(Math.min(Math.max(at(event), 0), this.known));
    });
    canvas.addEventListener("pointermove", (event) => {
      if (this.isHeld) return seek(Math.min(Math.max(at(event), 0), this.known));
      const mark = markAt(event);
      canvas.title = mark ? `${mark.cause} of ${mark.who} at ${mark.time.toFixed(2)} s` : "";
    });
    canvas.addEventListener("pointerup", () => (this.isHeld = false));
    new ResizeObserver(() => this.draw()).observe(canvas);
  }

  // `known` is up to where there are frames yet.
  show({ seconds, known = seconds, gait = [], events = [] }) {
    Object.assign(this, { seconds, known, gait, events });
    this.#fit();
  }

  showChannels({ curves, strips }) {
    Object.assign(this, { curves, strips });
    this.#fit();
  }

  #fit() {
    const rows = this.gait.reduce((sum, one) => sum + one.legs.length, 0);
    const channels = STRIP * this.strips.length + CURVE * this.curves.length;
    this.canvas.style.height = `${28 + 13 * rows + 6 + channels}px`;
    this.draw();
  }

  draw() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const ratio = devicePixelRatio;
    this.canvas.width = width * ratio;
    this.canvas.height = height * ratio;
    const context = this.canvas.getContext("2d");
    context.scale(ratio, ratio);
    const x = (time) => this.left + (time / this.seconds) * (width - this.left - 8);
    context.font = "11px system-ui";
    context.textBaseline = "middle";
    for (const sound of this.events) {
      context.fillStyle = sound.color;
      context.fillRect(x(sound.time) - 1, 2, 2, 12);
    }
    context.fillStyle = FAINT;
    const step = this.seconds > 20 ? 5 : this.seconds > 6 ? 1 : 0.5;
    for (let t = 0; t <= this.seconds; t += step) {
      context.fillRect(x(t), 17, 1, 5);
      const hasRoom = x(t) + 3 + context.measureText(`${t}`).width < width;
      context.textAlign = hasRoom ? "left" : "right";
      context.fillText(`${t}`, x(t) + (hasRoom ? 3 : -2), 20);
    }
    context.textAlign = "left";
    let y = 34;
    for (const { who, legs } of this.gait) {
      for (const leg of legs) {
        context.fillStyle = INK;
        context.fillText(this.gait.length > 1 ? `${who} ${leg.name}` : leg.name, 6, y, this.left - 12);
        context.fillStyle = leg.color;
        context.globalAlpha = 0.3;
        for (const [a, b] of leg.planned) context.fillRect(x(a), y - 5, x(b) - x(a), 4);
        context.globalAlpha = 1;
        for (const [a, b] of leg.actual) context.fillRect(x(a), y, x(b) - x(a), 5);
        y += 13;
      }
    }
    y = this.#drawStrips(context, x, y);
    this.#drawCurves(context, x, y, width);
    if (this.known < this.seconds) {
      context.fillStyle = "#d7d3c8a0";
      context.fillRect(x(this.known), 0, x(this.seconds) - x(this.known), height);
    }
    context.fillStyle = INK;
    context.fillRect(x(this.time), 0, 1.5, height);
  }

  // What a mind does and looks at.
  #drawStrips(context, x, y) {
    const names = [...new Set(this.strips.flatMap(({ spans }) => spans.map(([name]) => name)))];
    for (const { title, spans } of this.strips) {
      context.fillStyle = INK;
      context.fillText(title, 6, y);
      for (const [name, start, end] of spans) {
        context.fillStyle = COLORS[names.indexOf(name) % COLORS.length];
        context.globalAlpha = 0.35;
        context.fillRect(x(start), y - 6, x(end) - x(start) - 1, 12);
        context.globalAlpha = 1;
        context.fillStyle = INK;
        if (context.measureText(name).width + 6 < x(end) - x(start)) context.fillText(name, x(start) + 3, y);
      }
      y += STRIP;
    }
    return y;
  }

  // Channels, each between its least and greatest value, with the value of this moment.
  #drawCurves(context, x, y, width) {
    this.curves.forEach(({ name, unit, least, most, points }, k) => {
      const at = (value) => y + CURVE - 14 - ((value - least) / (most - least || 1)) * (CURVE - 8);
      context.fillStyle = INK;
      context.fillText(name, 6, y - 1, this.left - 12);
      const now = points.findLast(([time]) => time <= this.time + 1e-6) ?? points[0];
      context.fillStyle = FAINT;
      if (now) context.fillText(`${Number(now[1].toPrecision(4))} ${unit === "1" ? "" : unit}`, 6, y + 12, this.left - 12);
      context.fillRect(this.left, y + CURVE - 12, width - this.left - 8, 0.5);
      context.strokeStyle = COLORS[k % COLORS.length];
      context.lineWidth = 1.4;
      context.beginPath();
      for (const [time, value] of points) context.lineTo(x(time), at(value));
      context.stroke();
      y += CURVE;
    });
  }
}
