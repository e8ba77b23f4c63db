// IEEE binary16 to numbers, by table: the feed brings millions of them.

let table = null;

function decode(bits) {
  const sign = bits & 0x8000 ? -1 : 1;
  const exponent = bits >> 10 & 31, mantissa = bits & 1023;
  if (exponent === 31) return mantissa ? NaN : sign * Infinity;
  if (exponent === 0) return sign * mantissa * 2 ** -24;
  return sign * (1024 + mantissa) * 2 ** (exponent - 25);
}

// The 65536 values, indexed by their bits.
export function halfTable() {
  if (!table) table = Float32Array.from({ length: 65536 }, (_, bits) => decode(bits));
  return table;
}
