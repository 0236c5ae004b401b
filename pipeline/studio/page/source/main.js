// The page: which document is open, and what is done with it.

import { ask, guarded, isAgain, Refusal } from "./api.js";
import { Editor } from "./editor.js";
import { Library } from "./library.js";
import { Player } from "./player.js";
import { Renders } from "./renders.js";

const $ = (id) => document.getElementById(id);

function report(text, isBad = false) {
  $("status").textContent = text;
  $("status").classList.toggle("bad", isBad);
}

const editor = new Editor(report);
const player = new Player(report);
const renders = new Renders(report);
const library = new Library(report, (name) => open(name));
let shown = null;

function show(pane) {
  for (const id of ["library", "renders", "figure", "scene"]) $(id).hidden = id !== pane;
  $("tab-renders").classList.toggle("on", pane === "renders");
  $("tab-library").classList.toggle("on", pane === "library");
  for (const id of ["undo", "redo"]) $(id).hidden = pane !== "figure";
  if (pane === "figure" || pane === "scene") shown = pane === "figure" ? editor : player;
  if (pane !== "scene") player.pause();
  if (pane !== "library") library.pause();
  refresh();
}

function refresh() {
  const document_ = shown?.document;
  $("name").textContent = document_ ? `${document_.name || "new figure"}${shown.isDirty ? " •" : ""}` : "";
  $("save").disabled = !document_;
  if (document_) sessionStorage.studioDocument = document_.name;
}

editor.onChange = refresh;
player.onChange = refresh;

const open = (name) =>
  guarded(report, async () => {
    if (shown?.isDirty && !confirm("What was changed is not saved. Open another document?")) return false;
    const document_ = await ask("open", { name });
    show(document_.kind === "figure" ? "figure" : "scene");
    await shown.open(document_);
    if (document_.error) report(document_.error.split("\n")[0], true);
    else report(document_.is_shipped ? "of the library; saving makes a copy in this folder" : "");
    refresh();
  });

const save = () =>
  guarded(report, async () => {
    const { document: document_ } = shown;
    let { name } = document_;
    if (shown.isEmpty) return report("there is nothing to save yet", true);
    if (!name) {
      const wished = prompt("Name of the figure", "creature");
      if (!wished) return false;
      name = `figures/${wished.replace(/\.ya?ml$/, "")}.yaml`;
    }
    const before = document_.name && !document_.is_shipped ? document_.text : null;
    const message = { name, ...shown.content, before };
    let saved;
    try {
      saved = await ask("save", message);
    } catch (error) {
      if (!(error instanceof Refusal) || before === null) throw error;
      // Another program may have written the file since it was opened.
      const now = await ask("open", { name });
      if (now.text === before || !confirm(`${name} was changed by another program. Replace it?`)) throw error;
      saved = await ask("save", { ...message, before: now.text });
    }
    Object.assign(document_, saved);
    shown.wasSaved();
    report(`saved ${saved.name}`);
    refresh();
  });

const render = () =>
  guarded(report, async () => {
    if (player.isDirty || !player.document.name || player.document.is_shipped) {
      if (!(await save())) return false;
    }
    await ask("render", { name: player.document.name, preset: $("preset").value });
    show("renders");
    await renders.refresh();
  });

const showLibrary = () =>
  guarded(report, async () => {
    show("library");
    await library.show();
  });

$("tab-library").onclick = () => ($("library").hidden ? showLibrary() : show(shown === player ? "scene" : "figure"));
$("tab-renders").onclick = () =>
  guarded(report, async () => {
    if (!$("renders").hidden) return show(shown === player ? "scene" : "figure");
    show("renders");
    await renders.refresh();
  });
$("render-film").onclick = render;
for (const preset of (await ask("renders")).presets) $("preset").append(new Option(preset));
$("save").onclick = save;
$("undo").onclick = () => editor.undo();
$("redo").onclick = () => editor.redo();
window.addEventListener("keydown", (event) => {
  if ((event.ctrlKey || event.metaKey) && event.key === "s") {
    event.preventDefault();
    save();
  }
});
window.addEventListener("beforeunload", (event) => shown?.isDirty && event.preventDefault());

window.studio = { editor, player, library };
const { first } = await ask("library");
if (!(await open(isAgain ? sessionStorage.studioDocument || null : first))) {
  const { textContent } = $("status");
  await showLibrary();
  report(textContent, true);
}
window.studio.isReady = true;
