// A YAML text, with the schema's keys to complete and to read about, and its mistakes marked.

import { autocompletion } from "@codemirror/autocomplete";
import { indentWithTab } from "@codemirror/commands";
import { yaml } from "@codemirror/lang-yaml";
import { lintGutter, setDiagnostics } from "@codemirror/lint";
import { EditorState } from "@codemirror/state";
import { hoverTooltip, keymap } from "@codemirror/view";
import { basicSetup, EditorView } from "codemirror";

import { Draft, draggedValues } from "./dragged_values.js";
import { SchemaPlaces } from "./schema_places.js";
import { placeOf, plainOf } from "./text_tree.js";

// What may be written at a place: keys where a key stands, named values where a value does.
function completions(places, text, from, to) {
  const place = placeOf(text, from, to);
  if (!place) return [];
  const parts = places.at(place.path, place.plain);
  const options = [];
  if (place.isKey || place.isAlone) {
    const present = place.path.reduce((below, step) => below?.[step], place.plain);
    for (const [label, info] of places.keys(parts)) {
      if (present && typeof present === "object" && Object.hasOwn(present, label)) continue;
      const hasColon = /^[ \t]*:/.test(text.slice(to));
      options.push({ label, type: "property", info, apply: hasColon ? label : `${label}: ` });
    }
  }
  if (!place.isKey) {
    for (const [label, info] of places.values(parts)) options.push({ label, type: "constant", info });
    if (parts.some((part) => part.type === "string" && !part.enum)) {
      for (const label of ownNames(place.plain)) options.push({ label, type: "variable", info: "of this file" });
    }
  }
  return options;
}

// Names that a scene gives, its cast and what it defines, or the nodes of a figure.
function ownNames(plain) {
  const cast = (Array.isArray(plain?.cast) ? plain.cast : []).map((member) => member?.name);
  const defined = ["figures", "dances", "materials", "moods", "places"].flatMap((key) => Object.keys(plain?.[key] ?? {}));
  const nodes = Object.keys(plain?.figure?.nodes ?? {});
  return new Set([...cast, ...defined, ...nodes].filter((name) => typeof name === "string"));
}

export function textEditor(parent, schema, changed) {
  const places = new SchemaPlaces(schema);
  let lineEnd = "\n";
  const complete = (context) => {
    const word = context.matchBefore(/[\w-][\w -]*/) ?? context.matchBefore(/[\w-]+/);
    if (!word && !context.explicit) return null;
    const text = context.state.doc.toString();
    let from = word?.from ?? context.pos;
    // A list's dash belongs to the list.
    from += /^(- +)*/.exec(text.slice(from, context.pos))[0].length;
    const rest = /^[\w-]*/.exec(text.slice(context.pos))[0].length;
    const options = completions(places, text, from, context.pos + rest);
    return options.length ? { from, options, validFor: /^[\w -]*$/ } : null;
  };
  const help = hoverTooltip((view, position) => {
    const line = view.state.doc.lineAt(position);
    const at = position - line.from;
    const found = [...line.text.matchAll(/[\w-]+/g)].find((one) => one.index <= at && at <= one.index + one[0].length);
    if (!found) return null;
    const from = line.from + found.index;
    const place = placeOf(view.state.doc.toString(), from, from + found[0].length);
    if (!place) return null;
    const parts = places.at(place.path, place.plain);
    const text = place.isKey ? places.keys(parts).get(found[0]) : places.description(parts);
    if (!text) return null;
    const dom = Object.assign(document.createElement("div"), { textContent: `${found[0]}: ${text}` });
    dom.style.cssText = "max-width: 420px; padding: 4px 8px";
    return { pos: from, create: () => ({ dom }) };
  });
  const extensions = [
    basicSetup,
    keymap.of([indentWithTab]),
    yaml(),
    lintGutter(),
    autocompletion({ override: [complete] }),
    help,
    draggedValues,
    EditorView.updateListener.of((update) => update.docChanged && changed()),
    EditorView.theme({ "&": { fontSize: "13px" }, ".cm-scroller": { fontFamily: "ui-monospace, monospace" } }),
  ];
  const view = new EditorView({ parent, extensions });
  return {
    view,
    get text() {
      return view.state.doc.sliceString(0, undefined, lineEnd);
    },
    // Begins with another text, before which nothing can be undone.
    set text(value) {
      // The editor knows one kind of line end; the file keeps its own.
      lineEnd = value.includes("\r\n") ? "\r\n" : "\n";
      view.setState(EditorState.create({ doc: value, extensions }));
      changed();
    },
    // Replaces what differs, so that the cursor stays and it can be undone.
    write(value) {
      const [before, after] = [view.state.doc, view.state.toText(value)].map(String);
      let from = 0;
      while (from < before.length && before[from] === after[from]) from++;
      let [to, end] = [before.length, after.length];
      while (to > from && end > from && before[to - 1] === after[end - 1]) to--, end--;
      if (from < to || from < end) view.dispatch({ changes: { from, to, insert: after.slice(from, end) } });
    },
    get viewText() {
      return view.state.doc.toString();
    },
    get plain() {
      return plainOf(view.state.doc.toString());
    },
    draft: (from, to) => new Draft(view, from, to),
    completions: (from, to = from) => completions(places, view.state.doc.toString(), from, to).map(({ label }) => label),
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
