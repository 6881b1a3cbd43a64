// Words of a page in its language: the column of rattle/pages/words.csv that a scene brings, by their English texts.

// A function word(text, values): the text in the language of the page, with values in place of {name}.
export function speaking(words) {
  const own = new Map(Object.entries(words ?? {}));
  return (text, values = {}) => (own.get(text) ?? text).replace(/\{(\w+)\}/g, (whole, name) => values[name] ?? whole);
}

export const inEnglish = speaking({});
