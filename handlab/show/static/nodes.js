// Elements of a page, with data- and aria- attributes.

export const make = (tag, properties = {}, ...children) => {
  const { data, aria, ...plain } = properties;
  const node = Object.assign(document.createElement(tag), plain);
  for (const [key, value] of Object.entries(data || {})) node.dataset[key] = value;
  for (const [key, value] of Object.entries(aria || {})) node.setAttribute(key === "role" ? key : `aria-${key}`, value);
  node.append(...children.filter((child) => child !== null && child !== undefined));
  return node;
};
