// Text from the letters that `lettered` of rattle/pages/packed.py writes: five of them are four bytes, compressed.

const LETTERS = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz!#$%:()*+-;[=]?@^_,{|}~";

export async function unpackedText(letters) {
  if (typeof DecompressionStream === "undefined") throw new Error("this browser is too old (it has no DecompressionStream): please use a newer one");
  const worth = new Uint8Array(128), groups = Math.ceil(letters.length / 5), bytes = new Uint8Array(4 * groups), view = new DataView(bytes.buffer);
  for (let k = 0; k < LETTERS.length; k++) worth[LETTERS.charCodeAt(k)] = k;
  for (let n = 0; n < groups; n++) {
    let value = 0;
    for (let k = 5 * n; k < 5 * n + 5; k++) value = 85 * value + (k < letters.length ? worth[letters.charCodeAt(k)] : 84);
    view.setUint32(4 * n, value);
  }
  const whole = bytes.subarray(0, 4 * groups - (5 * groups - letters.length));
  try {
    return await new Response(new Blob([whole]).stream().pipeThrough(new DecompressionStream("gzip"))).text();
  } catch {
    throw new Error("this file is damaged: fetch it again, or write it anew");
  }
}
