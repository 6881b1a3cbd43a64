// Recorded functions of a page: exact operations on a tape, computed one after the other.
//
// written: of `rattle.pages.tape`.  A slot is a place on the tape: first inputs, then numbers, then operations.

import { bytesFrom } from "./core.js";

// opcodes in their order, see EXACT of rattle/trace/graph.py: add sub mul div, neg abs sqrt floor, less at_most equal both
// either, not, select, power_of_two exponent mantissa
const OPERANDS = [2, 2, 2, 2, 1, 1, 1, 1, 2, 2, 2, 2, 2, 1, 3, 1, 1, 1];
const SHIFT = 6755399441055744 + 1023; // added to a whole n it leaves n + 1023 in the lowest bits
const HIGH_HALF = new Uint32Array(new Float64Array([1]).buffer)[1] ? 1 : 0, LOW_HALF = 1 - HIGH_HALF;

/** The functions of a tape by their numbers: each (inp, out) => void over Float64Arrays. */
export async function openTape(written) {
  const bytes = await bytesFrom(written.content), [inputs, numbers, count] = written.counts, leaves = inputs + numbers;
  let at = count, next = inputs;
  const varint = () => {
    let value = 0, bits = 0;
    for (; bytes[at] > 0x7f; bits += 7) value |= (bytes[at++] & 0x7f) << bits;
    return value | (bytes[at++] << bits);
  };
  const opcodes = bytes.subarray(0, count), operands = [0, 1, 2].map(() => new Int32Array(count));
  operands.forEach((column, c) => {
    for (let k = 0; k < count; k++) {
      if (c >= OPERANDS[opcodes[k]]) continue;
      const reference = varint();
      column[k] = reference === 1 ? next++ : reference & 1 ? (reference - 3) / 2 : leaves + k - reference / 2;
    }
  });
  const slots = (length) => {
    let slot = 0;
    return Int32Array.from({ length }, () => {
      const step = varint();
      return (slot += step & 1 ? -(step + 1) / 2 : step / 2);
    });
  };
  const functions = written.functions.map(([given, early, asked]) => ({ inputs: slots(given), early, outputs: slots(asked) }));
  const planes = bytes.subarray(at), plain = new DataView(new ArrayBuffer(8 * numbers));
  for (let k = 0; k < 8 * numbers; k++) plain.setUint8(k, planes[(k % 8) * numbers + (k >> 3)]);
  const constants = Float64Array.from({ length: numbers }, (_, k) => plain.getFloat64(8 * k, true));
  const tape = { inputs, leaves, count, opcodes, operands, constants };
  return functions.map((own) => {
    let compute = null; // many are never called: until a parameter changes
    return (inp, out) => (compute ??= tapeFunction(tape, own))(inp, out);
  });
}

/** Functions by name, from those of a tape.  numbers: by name. */
export function functionsByName(functions, numbers) {
  return Object.fromEntries(Object.entries(numbers).map(([name, number]) => [name, functions[number]]));
}

// one function with values of its own: its inputs, the numbers it uses, its operations, of which those that follow from its
// early inputs alone come first and are computed again only when one of these changes
function tapeFunction({ inputs, leaves, count, opcodes, operands, constants }, { inputs: given, early, outputs }) {
  const live = new Uint8Array(leaves + count), late = new Uint8Array(leaves + count), place = new Int32Array(leaves + count);
  for (const slot of outputs) live[slot] = 1;
  for (let k = count - 1; k >= 0; k--)
    if (live[leaves + k]) for (let n = 0; n < OPERANDS[opcodes[k]]; n++) live[operands[n][k]] = 1;
  let first = given.length, split = 0, end = 0;
  given.forEach((slot, k) => { [place[slot], late[slot]] = [k, k < early ? 0 : 1]; });
  for (let slot = inputs; slot < leaves; slot++) if (live[slot]) place[slot] = first++;
  for (let k = 0; k < count; k++) {
    if (!live[leaves + k]) continue;
    for (let n = 0; n < OPERANDS[opcodes[k]]; n++) late[leaves + k] |= late[operands[n][k]];
    end++;
    split += 1 - late[leaves + k];
  }
  const codes = new Uint8Array(end), [a, b, c] = [0, 1, 2].map(() => new Int32Array(end)), next = [0, split];
  for (let k = 0; k < count; k++) {
    if (!live[leaves + k]) continue;
    const n = next[late[leaves + k]]++;
    place[leaves + k] = first + n;
    [codes[n], a[n], b[n], c[n]] = [opcodes[k], place[operands[0][k]], place[operands[1][k]], place[operands[2][k]]];
  }
  const values = new Float64Array(first + end), halves = new Uint32Array(values.buffer), results = outputs.map((slot) => place[slot]);
  for (let slot = inputs; slot < leaves; slot++) if (live[slot]) values[place[slot]] = constants[slot - inputs];
  let computed = false;
  return (inp, out) => {
    for (let k = 0; k < early; k++) computed &&= Object.is(values[k], inp[k]);
    for (let k = 0; k < given.length; k++) values[k] = inp[k];
    if (!computed) interpret(codes, a, b, c, values, halves, first, 0, split);
    computed = true;
    interpret(codes, a, b, c, values, halves, first, split, end);
    for (let k = 0; k < results.length; k++) out[k] = values[results[k]];
  };
}

function interpret(codes, a, b, c, y, halves, first, from, end) {
  for (let k = from; k < end; k++) {
    const x = a[k], at = first + k;
    switch (codes[k]) {
      case 0: y[at] = y[x] + y[b[k]]; break;
      case 1: y[at] = y[x] - y[b[k]]; break;
      case 2: y[at] = y[x] * y[b[k]]; break;
      case 3: y[at] = y[x] / y[b[k]]; break;
      case 4: y[at] = -y[x]; break;
      case 5: y[at] = Math.abs(y[x]); break;
      case 6: y[at] = Math.sqrt(y[x]); break;
      case 7: y[at] = Math.floor(y[x]); break;
      case 8: y[at] = y[x] < y[b[k]] ? 1 : 0; break;
      case 9: y[at] = y[x] <= y[b[k]] ? 1 : 0; break;
      case 10: y[at] = y[x] === y[b[k]] ? 1 : 0; break;
      case 11: y[at] = y[x] !== 0 && y[b[k]] !== 0 ? 1 : 0; break;
      case 12: y[at] = y[x] !== 0 || y[b[k]] !== 0 ? 1 : 0; break;
      case 13: y[at] = y[x] === 0 ? 1 : 0; break;
      case 14: y[at] = y[x] !== 0 ? y[b[k]] : y[c[k]]; break;
      case 15:
        y[at] = y[x] + SHIFT;
        halves[2 * at + HIGH_HALF] = (halves[2 * at + LOW_HALF] & 0xfff) << 20;
        halves[2 * at + LOW_HALF] = 0;
        break;
      case 16: y[at] = ((halves[2 * x + HIGH_HALF] >>> 20) & 0x7ff) - 1023; break;
      case 17:
        halves[2 * at + LOW_HALF] = halves[2 * x + LOW_HALF];
        halves[2 * at + HIGH_HALF] = (halves[2 * x + HIGH_HALF] & 0xfffff) | 0x3ff00000;
        break;
    }
  }
}
