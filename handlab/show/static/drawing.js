// Nodes of a drawing. Not part of the page in one file, which names no address.

const SVG = "http://www.w3.org/2000/svg";

export const draw = (tag, attributes = {}, ...children) => {
  const node = document.createElementNS(SVG, tag);
  for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
  node.append(...children);
  return node;
};
