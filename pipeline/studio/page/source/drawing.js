// A figure's drawing: nodes and chains as they are written, and the operations of Sims 1987, A.1.

export const empty = () => ({ nodes: {}, chains: [], is_mirrored: false, parts: {}, settings: {}, joints: {}, masses: {} });

export const copyOf = (drawing) => structuredClone(drawing);

export function twinName(name) {
  if (name.endsWith("_l")) return name.slice(0, -2) + "_r";
  if (name.endsWith("_r")) return name.slice(0, -2) + "_l";
  return name + "_m";
}

export function pairs(drawing) {
  const found = new Map();
  for (const chain of drawing.chains) {
    for (let i = 1; i < chain.length; i++) {
      const [a, b] = [chain[i - 1], chain[i]].sort();
      found.set(`${a}\n${b}`, [a, b]);
    }
  }
  return [...found.values()];
}

const isPair = (a, b, x, y) => (a === x && b === y) || (a === y && b === x);

export function isConnected(drawing, a, b) {
  return pairs(drawing).some(([x, y]) => isPair(a, b, x, y));
}

export function connect(drawing, a, b) {
  if (a === b || isConnected(drawing, a, b)) return;
  // A line that is drawn on stays one chain in the file.
  for (const chain of drawing.chains) {
    for (const [end, next] of [[a, b], [b, a]]) {
      if (chain[chain.length - 1] === end) return void chain.push(next);
      if (chain[0] === end) return void chain.unshift(next);
    }
  }
  drawing.chains.push([a, b]);
}

function split(drawing, isCut, drops) {
  drawing.chains = drawing.chains.flatMap((chain) => {
    const pieces = [[]];
    chain.forEach((name, i) => {
      if (i > 0 && isCut(chain[i - 1], name)) pieces.push([]);
      if (!drops(name)) pieces[pieces.length - 1].push(name);
    });
    return pieces.filter((piece) => piece.length > 1);
  });
}

export function disconnect(drawing, a, b) {
  split(drawing, (x, y) => isPair(a, b, x, y), () => false);
}

export function remove(drawing, names) {
  const gone = new Set(names);
  split(drawing, (x, y) => gone.has(x) || gone.has(y), (name) => gone.has(name));
  for (const name of gone) {
    delete drawing.nodes[name];
    for (const tip of drawing.is_mirrored ? [name, twinName(name)] : [name]) delete drawing.parts[tip];
  }
}

export function freeName(drawing, stem) {
  const suffix = /_[lr]$/.exec(stem)?.[0] ?? "";
  const base = suffix ? stem.slice(0, -2) : stem;
  if (!(stem in drawing.nodes) && !isTwin(drawing, stem)) return stem;
  const [, head, digits] = /^(.*?)([0-9]*)$/.exec(base);
  for (let n = (Number(digits) || 1) + 1; ; n++) {
    const name = `${head}${n}${suffix}`;
    if (!(name in drawing.nodes) && !isTwin(drawing, name)) return name;
  }
}

function isTwin(drawing, name) {
  if (!drawing.is_mirrored) return false;
  const source = twinName(name);
  return source in drawing.nodes && drawing.nodes[source].at[0] !== 0;
}

export function create(drawing, at, radius) {
  const side = drawing.is_mirrored ? (at[0] < 0 ? "_l" : at[0] > 0 ? "_r" : "") : "";
  const name = freeName(drawing, `n1${side}`);
  drawing.nodes[name] = { at: [...at], radius };
  return name;
}

export function rename(drawing, before, after) {
  const swap = (name) => (name === before ? after : name);
  drawing.nodes = Object.fromEntries(Object.entries(drawing.nodes).map(([k, v]) => [swap(k), v]));
  drawing.chains = drawing.chains.map((chain) => chain.map(swap));
  const twins = { [before]: after };
  if (drawing.is_mirrored) twins[twinName(before)] = twinName(after);
  drawing.parts = Object.fromEntries(
    Object.entries(drawing.parts).map(([k, v]) => [twins[k] ?? k, v]),
  );
}

export function centre(drawing, names) {
  const places = names.map((name) => drawing.nodes[name].at);
  const middle = (i) => places.reduce((sum, at) => sum + at[i], 0) / places.length;
  return [middle(0), middle(1)];
}

// Moves nodes, or copies them with the connections among them and to others; returns their names.
// `size` is the factor on their radii.
export function transform(drawing, names, map, copies, size = 1) {
  const place = (node) => ({
    at: map(node.at),
    radius: node.radius === null ? null : node.radius * size,
  });
  if (!copies) {
    for (const name of names) drawing.nodes[name] = { ...drawing.nodes[name], ...place(drawing.nodes[name]) };
    return names;
  }
  const twins = {};
  for (const name of names) {
    const other = freeName(drawing, name);
    drawing.nodes[other] = place(drawing.nodes[name]);
    twins[name] = other;
  }
  for (const [a, b] of pairs(drawing)) {
    if (a in twins || b in twins) connect(drawing, twins[a] ?? a, twins[b] ?? b);
  }
  return Object.values(twins);
}

// A copy on the other side; nodes on the axis are their own copies and tie it to the rest.
export function mirror(drawing, names, axis) {
  const twins = {};
  for (const name of names) {
    const node = drawing.nodes[name];
    if (Math.abs(node.at[axis]) < 1e-9) continue;
    const wished = axis === 0 ? twinName(name) : name + "_m";
    const other = wished in drawing.nodes ? freeName(drawing, wished) : wished;
    const at = [...node.at];
    at[axis] = -at[axis];
    drawing.nodes[other] = { at, radius: node.radius };
    twins[name] = other;
  }
  for (const [a, b] of pairs(drawing)) {
    if (a in twins || b in twins) connect(drawing, twins[a] ?? a, twins[b] ?? b);
  }
  return Object.values(twins);
}

// Whether a place lies inside an outline (Sims 1987, A.2); differences of angles are wrapped.
export function isInside([x, y], outline) {
  let sum = 0;
  for (let i = 0; i < outline.length; i++) {
    const [ax, ay] = outline[i];
    const [bx, by] = outline[(i + 1) % outline.length];
    const turn = Math.atan2(by - y, bx - x) - Math.atan2(ay - y, ax - x);
    sum += Math.atan2(Math.sin(turn), Math.cos(turn));
  }
  return Math.abs(sum) > Math.PI;
}
