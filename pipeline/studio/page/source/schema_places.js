// What a JSON Schema (draft-07) allows at a place of a document that is still being written.

const typeOf = (value) => (Array.isArray(value) ? "array" : value === null ? "null" : typeof value);

export class SchemaPlaces {
  constructor(schema) {
    this.schema = schema;
  }

  // The parts of the schema that apply to what stands at a path, in a document of plain values.
  at(path, plain) {
    let parts = this.#applied(this.schema, plain);
    for (const step of path) {
      plain = plain?.[step];
      parts = parts.flatMap((part) => this.#below(part, step)).flatMap((part) => this.#applied(part, plain));
    }
    return parts;
  }

  // The keys that are allowed in a mapping: name to description.
  keys(parts) {
    const found = new Map();
    for (const part of parts) {
      for (const [key, below] of Object.entries(part.properties ?? {})) {
        const text = this.#description(below);
        if (!found.get(key)) found.set(key, text);
      }
      for (const name of this.#names(part.propertyNames)) if (!found.has(name)) found.set(name, "");
    }
    return found;
  }

  // The values that are named: text to description.
  values(parts) {
    const found = new Map();
    for (const part of parts) {
      for (const name of this.#names(part)) if (!found.has(name)) found.set(name, part.description ?? "");
      if (part.type === "boolean") for (const name of ["true", "false"]) found.set(name, part.description ?? "");
    }
    return found;
  }

  description(parts) {
    return parts.map((part) => part.description).find(Boolean) ?? "";
  }

  #names(part) {
    const named = [...(part?.enum ?? []), ...(part && "const" in part ? [part.const] : [])];
    const below = [...(part?.anyOf ?? []), ...(part?.oneOf ?? [])].flatMap((one) => this.#names(one));
    return [...named, ...below].filter((one) => typeof one === "string" || typeof one === "number").map(String);
  }

  #description(part) {
    return part.description ?? (part.$ref ? this.#description(this.#target(part.$ref)) : "");
  }

  #target(reference) {
    return reference
      .slice(2)
      .split("/")
      .reduce((part, key) => part[decodeURIComponent(key)], this.schema);
  }

  #below(part, step) {
    if (typeof step === "number") {
      if (Array.isArray(part.items)) return part.items[step] ? [part.items[step]] : [];
      return part.items ? [part.items] : [];
    }
    if (part.properties && Object.hasOwn(part.properties, step)) return [part.properties[step]];
    const matching = Object.entries(part.patternProperties ?? {}).filter(([pattern]) => new RegExp(pattern, "u").test(step));
    if (matching.length) return matching.map(([, below]) => below);
    return typeof part.additionalProperties === "object" ? [part.additionalProperties] : [];
  }

  // A part with all that it refers to and that its conditions add for a value.
  #applied(part, value) {
    if (typeof part !== "object") return [];
    const found = [part];
    const add = (below) => found.push(...this.#applied(below, value));
    if (part.$ref) add(this.#target(part.$ref));
    for (const below of part.allOf ?? []) add(below);
    for (const below of [...(part.anyOf ?? []), ...(part.oneOf ?? [])]) if (this.#suits(below, value)) add(below);
    if (part.if) {
      const branch = this.#holds(part.if, value) ? part.then : part.else;
      if (branch) add(branch);
    }
    return found;
  }

  // Whether what is written so far may become this alternative.
  #suits(part, value) {
    if (value === null || value === undefined || typeof part !== "object") return true;
    if (part.$ref && !this.#suits(this.#target(part.$ref), value)) return false;
    if (part.type && ![part.type].flat().some((type) => this.#isType(type, value))) return false;
    if (typeOf(value) !== "object") return true;
    // An alternative that knows none of the keys there are is another's.
    const keys = Object.keys(value).filter((key) => part.properties && part.additionalProperties === false && !Object.hasOwn(part.properties, key));
    const fixed = Object.entries(part.properties ?? {}).every(([key, below]) => !("const" in below) || value[key] == null || value[key] === below.const);
    return fixed && (!keys.length || keys.length < Object.keys(value).length);
  }

  #isType(type, value) {
    return type === typeOf(value) || (type === "integer" && Number.isInteger(value));
  }

  // Whether a condition holds.
  #holds(part, value) {
    if (typeof part !== "object") return part !== false;
    const isObject = typeOf(value) === "object";
    if (part.$ref && !this.#holds(this.#target(part.$ref), value)) return false;
    if (part.type && ![part.type].flat().some((type) => this.#isType(type, value))) return false;
    if ("const" in part && value !== part.const) return false;
    if (part.enum && !part.enum.includes(value)) return false;
    if (part.pattern && typeof value === "string" && !new RegExp(part.pattern, "u").test(value)) return false;
    if (part.required && isObject && !part.required.every((key) => Object.hasOwn(value, key))) return false;
    if (part.not && this.#holds(part.not, value)) return false;
    if (part.allOf && !part.allOf.every((one) => this.#holds(one, value))) return false;
    if (part.anyOf && !part.anyOf.some((one) => this.#holds(one, value))) return false;
    if (part.oneOf && part.oneOf.filter((one) => this.#holds(one, value)).length !== 1) return false;
    if (!isObject) return true;
    if (part.propertyNames && !Object.keys(value).every((key) => this.#holds(part.propertyNames, key))) return false;
    return Object.entries(part.properties ?? {}).every(([key, below]) => !Object.hasOwn(value, key) || this.#holds(below, value[key]));
  }
}
