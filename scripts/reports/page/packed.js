"use strict";
// Everything of the report hangs on this one name.
const Swarm = { views: {} };

// Unpack what packing.py packed: real numbers (NaN where there are none) or whole ones, row by row.
Swarm.unpack = function (packed) {
  const bytes = Uint8Array.from(atob(packed.data), (letter) => letter.charCodeAt(0));
  const kinds = { i1: Int8Array, i2: Int16Array, i4: Int32Array };
  const whole = new kinds[packed.kind](bytes.buffer);
  if (packed.scale === undefined) return whole;
  const ABSENT = -32768;
  return Float32Array.from(whole, (value) => (value === ABSENT ? NaN : packed.middle + value * packed.scale));
};
