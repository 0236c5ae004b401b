// Bars over time: stances of feet, marks of sound events, and the present moment.

const INK = "#1f2933";
const FAINT = "#8a94a0";

export class Bars {
  constructor(canvas, seek, pick) {
    this.canvas = canvas;
    this.seconds = 1;
    this.gait = [];
    this.events = [];
    this.time = 0;
    this.left = 64;
    const at = (event) => {
      const box = canvas.getBoundingClientRect();
      return ((event.clientX - box.left - this.left) / (box.width - this.left - 8)) * this.seconds;
    };
    canvas.addEventListener("pointerdown", (event) => {
      const box = canvas.getBoundingClientRect();
      if (event.clientY - box.top < 16 && pick) {
        const time = at(event);
        const near = this.events
          .map((sound) => [Math.abs(sound.time - time), sound])
          .sort((a, b) => a[0] - b[0])[0];
        if (near && near[0] < this.seconds / 60) return pick(near[1]);
      }
      canvas.setPointerCapture(event.pointerId);
      this.isHeld = true;
      seek(Math.min(Math.max(at(event), 0), this.seconds));
    });
    canvas.addEventListener("pointermove", (event) => {
      if (this.isHeld) seek(Math.min(Math.max(at(event), 0), this.seconds));
    });
    canvas.addEventListener("pointerup", () => (this.isHeld = false));
    new ResizeObserver(() => this.draw()).observe(canvas);
  }

  show({ seconds, gait = [], events = [] }) {
    Object.assign(this, { seconds, gait, events });
    const rows = gait.reduce((sum, one) => sum + one.legs.length, 0);
    this.canvas.style.height = `${Math.min(28 + 13 * rows + 6, 220)}px`;
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
      context.fillText(`${t}`, x(t) + 3, 20);
    }
    let y = 34;
    for (const { legs } of this.gait) {
      for (const leg of legs) {
        context.fillStyle = INK;
        context.fillText(leg.name, 6, y);
        context.fillStyle = leg.color;
        context.globalAlpha = 0.3;
        for (const [a, b] of leg.planned) context.fillRect(x(a), y - 5, x(b) - x(a), 4);
        context.globalAlpha = 1;
        for (const [a, b] of leg.actual) context.fillRect(x(a), y, x(b) - x(a), 5);
        y += 13;
      }
    }
    context.fillStyle = INK;
    context.fillRect(x(this.time), 0, 1.5, height);
  }
}
