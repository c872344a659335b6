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

/** With a minus sign as wide as the plus, and none before a zero. */
export const minus = (number: string): string => number.replace(/^-(?=[0.]*$)/, '').replace('-', '\u2212');

/** Numbers stay with their units, and negative ones have a true minus sign. */
export const typeset = (text: string): string =>
  text.replace(/(^|[\s(])-(?=\d)/g, '$1\u2212').replace(/(\d) (?=[%°σ/]|[\p{L}²]{1,5}\b)/gu, '$1\u00a0').replace(/(±) (?=\d)/g, '$1\u00a0');
