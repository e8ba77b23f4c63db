// Labels in pictures: capitals and digits of five by seven dots, each row of a letter as five bits.
const ROWS = 7, COLUMNS = 5, SPACING = 1;
const letters = {
  A: "0e11111f111111", B: "1e11111e11111e", C: "0e11101010110e", D: "1e11111111111e", E: "1f10101e10101f",
  F: "1f10101e101010", G: "0e11101711110f", H: "1111111f111111", I: "0e04040404040e", J: "0702020202120c",
  K: "11121418141211", L: "1010101010101f", M: "111b1515111111", N: "11111915131111", O: "0e11111111110e",
  P: "1e11111e101010", Q: "0e11111115120d", R: "1e11111e141211", S: "0f10100e01011e", T: "1f040404040404",
  U: "1111111111110e", V: "11111111110a04", W: "1111111515150a", X: "11110a040a1111", Y: "1111110a040404",
  Z: "1f01020408101f", 0: "0e11131519110e", 1: "040c040404040e", 2: "0e11010204081f", 3: "1f02040201110e",
  4: "02060a121f0202", 5: "1f101e0101110e", 6: "0608101e11110e", 7: "1f010204080808", 8: "0e11110e11110e",
  9: "0e11110f01020c", "-": "0000001f000000", ",": "00000000040408", ".": "000000000c0c00", "/": "00010204081000",
};

export const LETTER_PX = { width: COLUMNS + SPACING, height: ROWS };

// Writes `text` in black into the picture `rgb` of a width in pixels, its upper left corner at (left, top).
export function write(text, rgb, width, left, top) {
  for (const [i, letter] of [...text.toUpperCase()].entries())
    for (let y = 0; y < ROWS; y++) {
      const bits = parseInt((letters[letter] ?? "00000000000000").slice(2 * y, 2 * y + 2), 16);
      for (let x = 0; x < COLUMNS; x++)
        if (bits >> (COLUMNS - 1 - x) & 1) rgb.fill(0, 3 * ((top + y) * width + left + i * LETTER_PX.width + x), 3 * ((top + y) * width + left + i * LETTER_PX.width + x) + 3);
    }
}
