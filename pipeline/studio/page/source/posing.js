// Posing: a part of the creature that was clicked, its mass, the limits and rest of its joints.
//
// The creature stands still in its rest pose meanwhile, by its own kinematics here, so that nothing
// waits for the server while a part is dragged.

import * as THREE from "three";

const GRAB = 12; // pixels within which a handle is taken
const CLICK = 4; // pixels that a click may move
const EDGE_ON = 0.12; // sine of the least angle between the view and the plane of a joint
const DEGREES_PER_PIXEL = 0.5; // where that plane is seen from its edge
const SEGMENTS = 48;
const COLORS = { yaw: "#2d6fb4", pitch: "#b4442f", bend: "#b4442f", roll: "#3f8f4f" };

const radians = (degrees) => (degrees * Math.PI) / 180;
const colorOf = (joint) => COLORS[joint.name.split("_").pop()] ?? "#b4442f";

export class Posing {
  // `board` has `drawing`, `analysis` and `problems`; `change` and `commit` make steps of undoing.
  constructor(viewer, panel, board) {
    this.viewer = viewer;
    this.panel = panel;
    this.board = board;
    this.link = null;
    this.bothSides = true;
    this.overlay = new THREE.Group();
    viewer.scene.add(this.overlay);
    const { canvas } = viewer;
    canvas.addEventListener("pointerdown", (event) => this.#down(event), { capture: true });
    canvas.addEventListener("pointermove", (event) => this.#move(event));
    canvas.addEventListener("pointerup", (event) => this.#up(event));
  }

  get links() {
    return this.board.analysis?.links ?? [];
  }

  get isOn() {
    return this.link !== null;
  }

  // "body", the name of a link, or null.
  select(name) {
    const isKnown = name === "body" || this.links.some((link) => link.name === name);
    this.link = isKnown ? name : null;
    const joints = this.#own()?.joints ?? [];
    // A limb is mostly raised and bent.
    this.joint = (joints.find((one) => /pitch|bend/.test(one.name)) ?? joints[0])?.name ?? null;
    if (this.link === null) this.viewer.release();
    this.board.showStance();
    this.refresh();
  }

  // After a change of the drawing, its analysis or the model.
  refresh() {
    if (this.link !== null && this.link !== "body" && this.links.length && !this.#own()) this.link = null;
    if (this.isOn) this.viewer.pose(this.links, (link, joint) => this.values(link, joint).rest);
    this.#drawArcs();
    this.#fillPanel();
    this.viewer.draw(Boolean(this.drag));
  }

  #own() {
    return this.links.find((link) => link.name === this.link);
  }

  // Least, greatest and rest value as drawn, otherwise as analysed [degrees or m].
  values(link, joint) {
    const own = this.board.drawing.joints?.[link.limb]?.[joint.name] ?? {};
    const [least, most] = (joint.slides ? own.slide : own.limits_deg) ?? [joint.lower, joint.upper];
    return { least, most, rest: (joint.slides ? own.rest : own.rest_deg) ?? joint.preferred };
  }

  // ---- changes

  // Writes values of a joint into the drawing, on both sides where the limb has a twin.
  #write(drawing, link, joint, { rest, limits }) {
    const sides = [[link.limb, 1]];
    if (this.bothSides && link.twin && joint.twin_sign) sides.push([link.twin, joint.twin_sign]);
    for (const [limb, sign] of sides) {
      this.#keepNeck(drawing, limb);
      const own = ((drawing.joints[limb] ??= {})[joint.name] ??= {});
      if (rest !== undefined) own[joint.slides ? "rest" : "rest_deg"] = tidy(sign * rest, joint);
      if (limits) {
        const ends = limits.map((value) => tidy(sign * value, joint));
        own[joint.slides ? "slide" : "limits_deg"] = sign > 0 ? ends : ends.reverse();
      }
    }
  }

  // Whoever writes one joint of a neck poses all of it: the others stay as they are by being written.
  #keepNeck(drawing, limb) {
    if (limb in drawing.joints) return;
    const links = this.links.filter((link) => link.limb === limb);
    if (links[0]?.kind !== "head" || drawing.settings.style !== "mammal") return;
    drawing.joints[limb] = {};
    for (const link of links) {
      for (const { name, slides, lower, upper, preferred } of link.joints) {
        if (slides || !/pitch|bend/.test(name)) continue;
        drawing.joints[limb][name] = { rest_deg: tidy(preferred), limits_deg: [tidy(lower), tidy(upper)] };
      }
    }
  }

  setJoint(name, values) {
    const link = this.#own();
    const joint = link.joints.find((one) => one.name === name);
    this.board.change((drawing) => this.#write(drawing, link, joint, values));
  }

  resetJoint(name) {
    const link = this.#own();
    this.board.change(({ joints }) => {
      for (const limb of this.bothSides && link.twin ? [link.limb, link.twin] : [link.limb]) {
        if (!joints[limb]) continue;
        delete joints[limb][name];
        if (!Object.keys(joints[limb]).length) delete joints[limb];
      }
    });
  }

  // The mass of the limb, NaN for that of its volume.
  setMass(mass) {
    const link = this.#own();
    const limb = link?.limb ?? "body";
    this.board.change(({ masses }) => {
      for (const one of this.bothSides && link?.twin ? [limb, link.twin] : [limb]) {
        if (Number.isNaN(mass)) delete masses[one];
        else masses[one] = mass;
      }
    });
  }

  // ---- mouse

  #down(event) {
    if (event.button !== 0) return;
    this.pressed = { x: event.clientX, y: event.clientY };
    const arc = this.arcs?.find(({ joint }) => joint.name === this.joint);
    const handle = arc && this.#handleAt(event, arc);
    const hit = handle ? null : this.viewer.partAt(event);
    if (!handle && !(arc && hit === this.link)) return;
    this.viewer.controls.enabled = false;
    this.viewer.canvas.setPointerCapture(event.pointerId);
    const before = JSON.stringify(this.board.drawing);
    const kind = handle ?? "rest";
    const { least, most, rest } = this.values(this.#own(), arc.joint);
    const start = { least, most, rest }[kind];
    this.drag = { arc, kind, before, start, least, most, rest, angle: this.#angleAt(event, arc), turned: 0, x: event.clientX };
  }

  #move(event) {
    const { drag } = this;
    if (!drag) return;
    if (drag.angle === null) drag.turned = (event.clientX - drag.x) * DEGREES_PER_PIXEL;
    else {
      const angle = this.#angleAt(event, drag.arc) ?? drag.angle;
      drag.turned += ((((angle - drag.angle + 180) % 360) + 360) % 360) - 180;
      drag.angle = angle;
    }
    const wished = Math.round(drag.start + drag.turned);
    const values = {
      rest: { rest: Math.min(Math.max(wished, drag.least), drag.most) },
      least: { limits: [Math.max(Math.min(wished, drag.rest), -180), drag.most] },
      most: { limits: [drag.least, Math.min(Math.max(wished, drag.rest), 180)] },
    }[drag.kind];
    const { joint } = drag.arc;
    // As it was before the drag, so that what a drag touches on its way leaves nothing behind.
    this.board.drawing = JSON.parse(drag.before);
    if (wished !== drag.start) this.#write(this.board.drawing, this.#own(), joint, values);
    this.refresh();
  }

  #up(event) {
    const { drag, pressed } = this;
    this.drag = this.pressed = null;
    this.viewer.controls.enabled = true;
    const isClick = pressed && Math.hypot(event.clientX - pressed.x, event.clientY - pressed.y) < CLICK;
    if (drag && drag.before !== JSON.stringify(this.board.drawing)) this.board.commit(drag.before);
    else if (isClick && drag?.kind !== "least" && drag?.kind !== "most") this.select(this.viewer.partAt(event));
  }

  #handleAt(event, arc) {
    let best = null;
    for (const [kind, place] of Object.entries(arc.handles)) {
      const [x, y] = this.viewer.onScreen(place);
      const away = Math.hypot(x - event.clientX, y - event.clientY);
      // Where two lie together, a limit may be moved away and the rest may not.
      if (away < GRAB && (!best || away < best.away - 2)) best = { kind, away };
    }
    return best?.kind ?? null;
  }

  // The angle of the pointer about a joint [degrees]; null where its plane is seen from the edge.
  #angleAt(event, { place, axis, zero, across }) {
    const ray = this.viewer.rayAt(event);
    const slope = ray.direction.dot(axis);
    if (Math.abs(slope) < EDGE_ON) return null;
    const reach = place.clone().sub(ray.origin).dot(axis) / slope;
    const away = ray.at(reach, new THREE.Vector3()).sub(place);
    return (Math.atan2(away.dot(across), away.dot(zero)) * 180) / Math.PI;
  }

  // ---- arcs

  #drawArcs() {
    for (const object of [...this.overlay.children]) {
      this.overlay.remove(object);
      object.geometry.dispose();
      object.material.dispose();
    }
    this.arcs = [];
    const link = this.#own();
    const node = link && this.viewer.nodeOf(link.name);
    const parent = link && this.viewer.nodeOf(link.parent);
    if (!node || !parent) return;
    const place = node.getWorldPosition(new THREE.Vector3());
    const turn = parent.getWorldQuaternion(new THREE.Quaternion());
    const turns = link.joints.map((joint) => turnOf(joint, this.values(link, joint).rest));
    const along = new THREE.Vector3(...link.along);
    const size = this.viewer.fitted ?? 1;
    const radius = Math.min(Math.max(along.length() * this.viewer.scale * 0.7, size * 0.1), size * 0.25);
    link.joints.forEach((joint, i) => {
      if (joint.slides) return;
      const axis = new THREE.Vector3(...joint.axis).applyQuaternion(turn).normalize();
      const far = along.clone();
      for (let k = turns.length - 1; k > i; k--) far.applyQuaternion(turns[k]);
      const zero = far.applyQuaternion(turn).projectOnPlane(axis);
      if (zero.length() < 0.15 * along.length()) {
        zero.set(0, 1, 0).projectOnPlane(axis);
        if (zero.length() < 0.1) zero.set(1, 0, 0).projectOnPlane(axis);
      }
      zero.normalize();
      const across = axis.clone().cross(zero);
      this.#drawArc({ joint, place, axis, zero, across, radius }, this.values(link, joint));
      turn.multiply(turns[i]);
    });
  }

  #drawArc(arc, { least, most, rest }) {
    const isActive = arc.joint.name === this.joint;
    const at = (degrees, reach = 1) =>
      arc.place
        .clone()
        .addScaledVector(arc.zero, Math.cos(radians(degrees)) * arc.radius * reach)
        .addScaledVector(arc.across, Math.sin(radians(degrees)) * arc.radius * reach);
    const color = colorOf(arc.joint);
    const rim = Array.from({ length: SEGMENTS + 1 }, (_, k) => at(least + ((most - least) * k) / SEGMENTS));
    const options = { color, transparent: true, depthTest: false, side: THREE.DoubleSide };
    const add = (object) => {
      object.renderOrder = 10;
      this.overlay.add(object);
    };
    if (isActive) {
      const fan = new THREE.BufferGeometry().setFromPoints([arc.place, ...rim]);
      fan.setIndex(Array.from({ length: SEGMENTS }, (_, k) => [0, k + 1, k + 2]).flat());
      add(new THREE.Mesh(fan, new THREE.MeshBasicMaterial({ ...options, opacity: 0.22 })));
    }
    const line = (points, opacity) =>
      add(
        new THREE.Line(
          new THREE.BufferGeometry().setFromPoints(points),
          new THREE.LineBasicMaterial({ ...options, opacity }),
        ),
      );
    line([arc.place, ...rim, arc.place], isActive ? 1 : 0.35);
    line([arc.place, at(rest, 1.15)], isActive ? 1 : 0.35);
    arc.handles = { least: at(least), most: at(most), rest: at(rest, 1.15) };
    this.arcs.push(arc);
    if (!isActive) return;
    for (const [kind, middle] of Object.entries(arc.handles)) {
      const ball = new THREE.SphereGeometry(arc.radius * (kind === "rest" ? 0.085 : 0.06), 16, 10);
      const mesh = new THREE.Mesh(ball, new THREE.MeshBasicMaterial({ ...options, color: kind === "rest" ? "#ffffff" : color }));
      mesh.position.copy(middle);
      add(mesh);
      if (kind !== "rest") continue;
      const core = new THREE.Mesh(
        new THREE.SphereGeometry(arc.radius * 0.055, 16, 10),
        new THREE.MeshBasicMaterial(options),
      );
      core.position.copy(middle);
      add(core);
    }
  }

  // ---- panel

  #fillPanel() {
    this.panel.hidden = !this.isOn;
    // Fields keep the cursor: they are made anew only for another part.
    const key = JSON.stringify([this.link, this.#own()?.joints.map((joint) => [joint.name, joint.slides])]);
    if (this.isOn && key !== this.filled) this.#buildPanel();
    this.filled = this.isOn ? key : null;
    if (!this.isOn) return;
    const link = this.#own();
    const limb = link?.limb ?? "body";
    const { drawing, analysis } = this.board;
    const show = (input, value, isGiven) => {
      if (document.activeElement !== input || !input.isDirty) input.value = value;
      input.classList.toggle("given", isGiven);
    };
    show(this.mass, Number((drawing.masses[limb] ?? analysis.masses[limb] ?? 0).toPrecision(4)), limb in drawing.masses);
    this.#mark(this.mass, `masses.${limb}`);
    for (const row of this.rows) {
      const { least, most, rest } = this.values(link, row.joint);
      const own = drawing.joints[limb]?.[row.joint.name] ?? {};
      row.joint = link.joints.find((joint) => joint.name === row.joint.name);
      show(row.least, least, "limits_deg" in own || "slide" in own);
      show(row.rest, rest, "rest_deg" in own || "rest" in own);
      show(row.most, most, "limits_deg" in own || "slide" in own);
      row.reset.disabled = !Object.keys(own).length;
      row.element.classList.toggle("on", row.joint.name === this.joint);
      for (const input of [row.least, row.rest, row.most]) this.#mark(input, `joints.${limb}.${row.joint.name}`);
    }
  }

  // Marks a field whose value is refused.
  #mark(input, path) {
    const found = this.board.problems?.find((one) => one.path.includes(path));
    input.classList.toggle("bad", Boolean(found));
    input.title = found?.message ?? "";
  }

  #buildPanel() {
    const link = this.#own();
    const make = (tag, words, ...children) => {
      const element = Object.assign(document.createElement(tag), words);
      element.append(...children);
      return element;
    };
    const field = (label, step, set) => {
      const input = make("input", { type: "number", step, ariaLabel: label });
      input.oninput = () => (input.isDirty = true);
      input.onchange = () => {
        input.isDirty = false;
        set(input.value === "" ? NaN : Number(input.value));
      };
      return input;
    };
    const limb = link?.limb ?? "body";
    this.mass = field("mass", "any", (mass) => this.setMass(mass));
    const title = make("div", { className: "title" }, make("strong", { textContent: this.link }));
    if (link?.twin) {
      const both = make("input", { type: "checkbox", checked: this.bothSides, onchange: () => (this.bothSides = both.checked) });
      title.append(make("label", { title: `${link.twin} as well` }, both, "both sides"));
    }
    title.append(make("button", { textContent: "Done", title: "Esc: walk on", onclick: () => this.select(null) }));
    const mass = make("label", { className: "mass" }, `mass of ${limb === "body" ? "the body" : limb} `, this.mass, " kg");
    const table = make("table", {});
    this.rows = (link?.joints ?? []).map((joint) => {
      const { name, slides } = joint;
      const step = slides ? 0.01 : 1;
      const values = () => this.values(this.#own(), this.#own().joints.find((one) => one.name === name));
      const set = (change) => (value) => (Number.isNaN(value) ? this.resetJoint(name) : this.setJoint(name, change(value)));
      const row = {
        joint,
        least: field(`${name} least`, step, set((value) => ({ limits: [value, values().most] }))),
        rest: field(`${name} rest`, step, set((value) => ({ rest: value }))),
        most: field(`${name} greatest`, step, set((value) => ({ limits: [values().least, value] }))),
        reset: make("button", { textContent: "↺", title: "as its style makes it", onclick: () => this.resetJoint(name) }),
        element: table.insertRow(),
      };
      const choose = make("button", { textContent: name.replace("_", " "), title: "turn about this axis", className: "joint" });
      choose.style.borderLeft = `4px solid ${colorOf(joint)}`;
      choose.onclick = () => {
        this.joint = name;
        this.refresh();
      };
      for (const cell of [choose, row.least, row.rest, row.most, slides ? "m" : "°", row.reset]) row.element.insertCell().append(cell);
      return row;
    });
    if (this.rows.length) {
      const head = table.createTHead().insertRow();
      for (const text of ["", "least", "rest", "greatest"]) head.insertCell().textContent = text;
    }
    const note = this.rows.length ? "Drag the part for its rest pose, the ends of the arc for its limits." : "";
    this.panel.replaceChildren(title, mass, table, make("div", { className: "why", textContent: note }));
  }
}

const tidy = (value, joint) => Number(value.toFixed(joint?.slides ? 4 : 1)) + 0;

export function turnOf(joint, value) {
  return new THREE.Quaternion().setFromAxisAngle(new THREE.Vector3(...joint.axis).normalize(), joint.slides ? 0 : radians(value));
}
