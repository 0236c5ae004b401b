// The tree of a YAML text: which keys lead to a place in it, also while it is being written.

import { isCollection, isPair, isScalar, isSeq, parseDocument } from "yaml";

const CURSOR = "pronkcursor"; // stands for the word that is being written

// All scalars with the keys that lead to them: {path, from, to, value, parents}.
export function scalars(text) {
  const found = [];
  const visit = (node, path, parents) => {
    if (isScalar(node) && node.range) {
      found.push({ path, from: node.range[0], to: node.range[1], value: node.value, parents });
    } else if (isCollection(node)) {
      node.items.forEach((item, k) => {
        if (isPair(item)) visit(item.value, [...path, String(item.key?.value ?? item.key)], [...parents, node]);
        else visit(item, [...path, k], [...parents, node]);
      });
    }
  };
  visit(parseDocument(text, { logLevel: "silent" }).contents, [], []);
  return found;
}

// All lists of numbers, such as places: {path, from, to, numbers: [{from, to, value}]}.
export function numberLists(text) {
  const found = new Map();
  for (const one of scalars(text)) {
    const parent = one.parents.at(-1);
    if (!isSeq(parent) || !parent.range) continue;
    if (!found.has(parent)) {
      found.set(parent, { path: one.path.slice(0, -1), from: parent.range[0], to: parent.range[1], numbers: [], size: parent.items.length });
    }
    if (typeof one.value === "number") found.get(parent).numbers.push(one);
  }
  return [...found.values()].filter(({ numbers, size }) => numbers.length === size);
}

// What is written between two places: whether it is a key or a value, the keys that lead there, and
// the whole text as plain values without it.
export function placeOf(text, from, to) {
  const doc = parseDocument(text.slice(0, from) + CURSOR + text.slice(to), { logLevel: "silent", uniqueKeys: false });
  let place = null;
  const visit = (node, path) => {
    if (place || !isCollection(node)) return;
    node.items.forEach((item, k) => {
      if (place) return;
      if (!isPair(item)) {
        if (isScalar(item) && item.value === CURSOR) {
          place = { path: [...path, k], isKey: false, isAlone: isSeq(node) && !node.flow };
          node.items[k].value = null;
        } else visit(item, [...path, k]);
      } else if (item.key?.value === CURSOR) {
        place = { path, isKey: true };
        node.items.splice(k, 1);
      } else if (isScalar(item.value) && item.value.value === CURSOR) {
        // A word on a line of its own below its key may become a key there.
        const isBelow = text.slice(item.key.range[1], from).includes("\n");
        place = { path: [...path, String(item.key.value)], isKey: false, isAlone: isBelow };
        item.value.value = null;
      } else visit(item.value, [...path, String(item.key?.value ?? item.key)]);
    });
  };
  if (isScalar(doc.contents) && doc.contents.value === CURSOR) return { path: [], isKey: true, plain: {} };
  visit(doc.contents, []);
  if (!place) return null;
  return { ...place, plain: plainOfDocument(doc) };
}


// The text as plain values, as far as it can be read.
export function plainOf(text) {
  return plainOfDocument(parseDocument(text, { logLevel: "silent", uniqueKeys: false }));
}

function plainOfDocument(doc) {
  try {
    return doc.toJS();
  } catch {
    return null; // an alias without its anchor
  }
}
