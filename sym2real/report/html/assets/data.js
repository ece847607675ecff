// The report's arrays: rows of numbers as JSON, zlib, base64; null is a gap.

async function inflated(text) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  return await new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"))).json();
}

// Three digits, and no row of zeros.
function figures(value) {
  if (value == null) return "–";
  return value !== 0 && Math.abs(value) < 1e-4 ? value.toExponential(2) : String(Number(value.toPrecision(3)));
}

export class Arrays {
  static async read(text) {
    return new Arrays(await inflated(text));
  }

  constructor(rows) {
    this.rows = rows;
  }

  // The row of a combination of switches, or the only one.
  row(number, combination) {
    return this.rows[number][combination] ?? this.rows[number][0];
  }
}
