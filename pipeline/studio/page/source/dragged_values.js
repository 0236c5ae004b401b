// Values that are dragged in the text: numbers to the left and right, colours in a picker.

import { RangeSetBuilder, Transaction } from "@codemirror/state";
import { Decoration, EditorView, ViewPlugin, WidgetType } from "@codemirror/view";

import { scalars } from "./text_tree.js";

const PIXELS = 4; // of the mouse for a step of the last digit
const NUMBER = /^[-+]?\d+(\.\d+)?$/;
const COLOR = /^["']?(#[0-9a-fA-F]{6})["']?$/;

// A number some steps of its last digit further; at least a hundredth of itself a step.
export function stepped(text, steps) {
  const decimals = text.split(".")[1]?.length ?? 0;
  const last = 10 ** -decimals;
  const step = Math.max(last, 10 ** Math.floor(Math.log10(Math.max(Math.abs(Number(text)) / 100, last))));
  return (Number(text) + steps * step).toFixed(decimals).replace(/^-(0(\.0*)?)$/, "$1");
}

// Writes a value over another many times, as one step of undoing.
export class Draft {
  constructor(view, from, to) {
    this.view = view;
    this.from = from;
    this.to = to;
    this.before = view.state.doc.sliceString(from, to);
  }

  write(text) {
    this.#replace(text, false);
  }

  end() {
    const text = this.view.state.doc.sliceString(this.from, this.to);
    if (text === this.before) return;
    this.#replace(this.before, false);
    this.#replace(text, true);
  }

  #replace(insert, isStep) {
    const { from, to } = this;
    this.to = from + insert.length;
    this.view.dispatch({ changes: { from, to, insert }, annotations: Transaction.addToHistory.of(isStep) });
  }
}

class Swatch extends WidgetType {
  constructor(color, from, to) {
    super();
    Object.assign(this, { color, from, to });
  }

  eq(other) {
    return other.color === this.color && other.from === this.from;
  }

  // While its picker is open the same element stays.
  updateDOM(element) {
    element.value = this.color;
    element.swatch = this;
    return true;
  }

  toDOM(view) {
    const input = Object.assign(document.createElement("input"), { type: "color", value: this.color, className: "swatch" });
    input.swatch = this;
    let draft = null;
    input.oninput = () => {
      draft ??= new Draft(view, input.swatch.from, input.swatch.to);
      draft.write(`"${input.value}"`);
    };
    input.onchange = () => {
      draft?.end();
      draft = null;
    };
    return input;
  }

  ignoreEvent() {
    return true;
  }
}

const number = Decoration.mark({ class: "cm-dragged-number" });

function decorated(view) {
  const text = view.state.doc.toString();
  const builder = new RangeSetBuilder();
  for (const { from, to } of scalars(text)) {
    const written = text.slice(from, to);
    if (NUMBER.test(written)) builder.add(from, to, number);
    const color = COLOR.exec(written);
    if (color) builder.add(from, from, Decoration.widget({ widget: new Swatch(color[1].toLowerCase(), from, to), side: -1 }));
  }
  return builder.finish();
}

// Starts a drag on a number; a press without movement sets the cursor as anywhere else.
function press(event, view) {
  const element = event.target.closest?.(".cm-dragged-number");
  if (!element || event.button !== 0 || event.shiftKey || event.detail > 1) return false;
  const from = view.posAtDOM(element, 0);
  const before = /^[-+]?\d+(\.\d+)?/.exec(view.state.doc.sliceString(from, from + 40))?.[0];
  if (!before) return false;
  event.preventDefault();
  view.focus();
  const draft = new Draft(view, from, from + before.length);
  const start = event.clientX;
  let shown = before;
  const move = (moved) => {
    const text = stepped(before, Math.trunc((moved.clientX - start) / PIXELS));
    if (text !== shown) draft.write((shown = text));
  };
  const end = (ended) => {
    window.removeEventListener("pointermove", move);
    window.removeEventListener("pointerup", end);
    draft.end();
    if (shown !== before) return;
    const position = view.posAtCoords({ x: ended.clientX, y: ended.clientY });
    if (position !== null) view.dispatch({ selection: { anchor: position } });
  };
  window.addEventListener("pointermove", move);
  window.addEventListener("pointerup", end);
  return true;
}

export const draggedValues = [
  ViewPlugin.fromClass(
    class {
      constructor(view) {
        this.decorations = decorated(view);
      }
      update(update) {
        if (update.docChanged) this.decorations = decorated(update.view);
      }
    },
    { decorations: (plugin) => plugin.decorations },
  ),
  EditorView.domEventHandlers({ mousedown: press }),
];
