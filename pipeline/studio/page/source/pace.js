// How much a view may draw while it moves, by how long its frames take.
//
// The name of the renderer is where it starts; it may be masked, or that of a slow processor, so
// that only durations decide from then on.

export const SOFTWARE_TRIANGLES = 20000;
export const GPU_TRIANGLES = 800000;
const RENDERER_NAMES = /swiftshader|llvmpipe|lavapipe|softpipe|software|basic render/i;
const TARGET = 1000 / 60; // ms of a frame
const SLOW = 24; // ms of a frame of which there is too much to draw
const QUICK = 19; // ms of a frame of which there may be more
const FRAMES = 5; // of which the median counts
const GROWTH = 1.5; // of the triangles after quick frames
const PATIENCE = 20; // quick medians after which what was too slow is tried again
const STUBBORN = 4; // slow medians with the fewest triangles after which materials are the reason

// Whether the renderer's name says that pages are drawn without a graphics processor.
export function isNamedSoftware() {
  const context = document.createElement("canvas").getContext("webgl2");
  const info = context?.getExtension("WEBGL_debug_renderer_info");
  const name = info ? context.getParameter(info.UNMASKED_RENDERER_WEBGL) : "";
  context?.getExtension("WEBGL_lose_context")?.loseContext();
  return RENDERER_NAMES.test(name);
}

export class Pace {
  // `isLight`: whether materials have to take little to draw, too.
  constructor(isSoftware) {
    this.isLight = isSoftware;
    this.budget = isSoftware ? SOFTWARE_TRIANGLES : GPU_TRIANGLES;
    this.durations = [];
    this.tooMany = Infinity;
    this.quick = this.stubborn = 0;
  }

  // Takes in the duration of a frame [ms] and its triangles; tells whether anything has to change.
  took(duration, triangles) {
    this.durations.push(duration);
    if (this.durations.length < FRAMES) return false;
    const median = this.durations.sort((a, b) => a - b)[FRAMES >> 1];
    this.durations = [];
    if (median > SLOW) return this.#less(median, Math.min(triangles, this.budget));
    this.stubborn = 0;
    this.quick = median < QUICK ? this.quick + 1 : 0;
    if (this.quick >= PATIENCE) this.tooMany = Infinity;
    // More triangles than there are need no larger budget.
    const isUsed = triangles > this.budget / 2;
    if (!this.quick || !isUsed || this.budget * GROWTH >= Math.min(this.tooMany, GPU_TRIANGLES)) return false;
    this.budget *= GROWTH;
    return true;
  }

  #less(median, triangles) {
    this.quick = 0;
    if (this.budget <= SOFTWARE_TRIANGLES) {
      this.stubborn += 1;
      if (this.isLight || this.stubborn < STUBBORN) return false;
      return (this.isLight = true);
    }
    this.tooMany = this.budget;
    this.budget = Math.max((triangles * TARGET) / median, SOFTWARE_TRIANGLES);
    return true;
  }
}
