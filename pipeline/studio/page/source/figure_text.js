// The text of a figure beside its drawing: what is typed is drawn, what is drawn is written.

import { ask, guarded, latest } from "./api.js";
import { textEditor } from "./text_editor.js";

export class FigureText {
  // `board` has `base`, the text into which its `drawing` is put; `takeText` draws, `lock` lets nothing be drawn.
  constructor(element, board, report) {
    this.element = element;
    this.board = board;
    this.report = report;
    this.editor = null;
    // What is typed and not drawn: it is being read, or it is no figure.
    this.typed = null;
    this.check = latest((text) => guarded(this.report, () => this.#check(text)));
    this.follow = latest(() => guarded(this.report, () => this.#follow()));
  }

  get isShown() {
    return !this.element.hidden;
  }

  // A text that is no figure is shown, to be mended.
  async open({ drawing, text, problems }) {
    this.typed = null;
    if (!drawing) await this.show(true);
    if (!this.editor) return;
    this.#write(() => (this.editor.text = text));
    if (!drawing) this.typed = text;
    this.editor.mark(problems);
  }

  async show(isShown) {
    if (isShown && !this.editor) {
      const schema = await ask("schema", { kind: "figure" });
      this.editor = textEditor(this.element, schema, () => this.#changed());
      this.#write(() => (this.editor.text = this.board.base));
    }
    this.element.hidden = !isShown;
    if (isShown) await this.follow();
  }

  #write(work) {
    this.isWriting = true;
    work();
    this.isWriting = false;
  }

  #changed() {
    if (this.isWriting) return;
    this.typed = this.editor.text;
    this.board.onChange?.();
    this.check(this.typed);
  }

  async #check(text) {
    const { drawing, error, problems } = await ask("check", { kind: "figure", text });
    if (text !== this.editor.text) return;
    this.editor.mark(problems);
    this.report(error.split("\n")[0], Boolean(error));
    if (this.typed === null) return;
    this.board.lock(!drawing);
    if (!drawing) return;
    this.typed = null;
    this.board.takeText(text, drawing);
  }

  // Writes what the board has drawn into the text.
  async #follow() {
    if (!this.isShown || this.typed !== null) return;
    const { text } = await ask("text", { text: this.board.base, drawing: this.board.drawing });
    if (this.typed !== null) return;
    this.#write(() => this.editor.write(text));
    await this.check(this.editor.text);
  }
}
