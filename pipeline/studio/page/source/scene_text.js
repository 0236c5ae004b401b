// The text of a scene, with the schema's keys to complete and to read about, and its mistakes marked.

import { autocompletion } from "@codemirror/autocomplete";
import { indentWithTab } from "@codemirror/commands";
import { yaml } from "@codemirror/lang-yaml";
import { lintGutter, setDiagnostics } from "@codemirror/lint";
import { hoverTooltip, keymap } from "@codemirror/view";
import { basicSetup, EditorView } from "codemirror";

// All keys and names of a schema, with what it says about them.
function wordsOf(schema) {
  const words = new Map();
  const add = (label, type, info) => {
    if (/^[\w][\w -]*$/.test(label) && !(words.get(label)?.info && !info)) words.set(label, { label, type, info });
  };
  const visit = (part) => {
    if (!part || typeof part !== "object") return;
    for (const [key, below] of Object.entries(part.properties ?? {})) add(key, "property", below.description);
    for (const value of [...(part.enum ?? []), part.const]) if (typeof value === "string") add(value, "constant", part.description);
    for (const below of Object.values(part)) visit(below);
  };
  visit(schema);
  return words;
}

export function textEditor(parent, schema, changed) {
  const words = wordsOf(schema);
  let lineEnd = "\n";
  const options = [...words.values()];
  const complete = (context) => {
    const word = context.matchBefore(/[\w-]+/);
    return word || context.explicit ? { from: word?.from ?? context.pos, options, validFor: /^[\w -]*$/ } : null;
  };
  const help = hoverTooltip((view, position) => {
    const line = view.state.doc.lineAt(position);
    const at = position - line.from;
    const found = [...line.text.matchAll(/[\w-]+/g)].find((one) => one.index <= at && at <= one.index + one[0].length);
    const word = found && words.get(found[0]);
    if (!word?.info) return null;
    const dom = Object.assign(document.createElement("div"), { textContent: `${word.label}: ${word.info}` });
    dom.style.cssText = "max-width: 420px; padding: 4px 8px";
    return { pos: line.from + found.index, create: () => ({ dom }) };
  });
  const view = new EditorView({
    parent,
    extensions: [
      basicSetup,
      keymap.of([indentWithTab]),
      yaml(),
      lintGutter(),
      autocompletion({ override: [complete] }),
      help,
      EditorView.updateListener.of((update) => update.docChanged && changed()),
      EditorView.theme({ "&": { fontSize: "13px" }, ".cm-scroller": { fontFamily: "ui-monospace, monospace" } }),
    ],
  });
  return {
    view,
    get text() {
      return view.state.doc.sliceString(0, undefined, lineEnd);
    },
    set text(value) {
      // The editor knows one kind of line end; the file keeps its own.
      lineEnd = value.includes("\r\n") ? "\r\n" : "\n";
      view.dispatch({ changes: { from: 0, to: view.state.doc.length, insert: value } });
    },
    mark(problems) {
      const { doc } = view.state;
      const found = problems.map((problem) => {
        const line = doc.line(Math.min(Math.max(problem.line, 1), doc.lines));
        const from = Math.min(line.from + Math.max(problem.column - 1, 0), line.to);
        const rest = /^[\w.#-]+/.exec(line.text.slice(from - line.from));
        return {
          from,
          to: Math.min(from + (rest ? rest[0].length : 1), line.to),
          severity: "error",
          message: problem.path ? `${problem.path}: ${problem.message}` : problem.message,
        };
      });
      view.dispatch(setDiagnostics(view.state, found));
    },
  };
}
