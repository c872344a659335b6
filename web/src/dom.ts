// SPDX-License-Identifier: MIT
export function element<T extends HTMLElement = HTMLElement>(id: string): T {
  const found = document.getElementById(id);
  if (!found) throw new Error(`the page has no element ${id}`);
  return found as T;
}

/** A new element with text (never HTML: names of files may hold anything) and children. */
export function make(tag: string, text = '', className = '', ...children: Node[]): HTMLElement {
  const made = document.createElement(tag);
  if (text) made.textContent = text;
  if (className) made.className = className;
  made.append(...children);
  return made;
}
