// The report's arrays: 16 bits a number, differences, low bytes before high bytes, zlib, base64.

const GAP = -32768;

async function inflated(text) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

function summedUp(planes) {
  const count = planes.length / 2;
  const steps = new Int16Array(count);
  let sum = 0;
  for (let i = 0; i < count; i++) {
    sum += planes[i] | (planes[count + i] << 8);
    steps[i] = sum;
  }
  return steps;
}

// Three digits, and no row of zeros.
function figures(value) {
  if (value == null) return "–";
  return value !== 0 && Math.abs(value) < 1e-4 ? value.toExponential(2) : String(Number(value.toPrecision(3)));
}

export class Arrays {
  static async read({ directory, text }) {
    return new Arrays(directory, summedUp(await inflated(text)));
  }

  constructor(directory, steps) {
    this.directory = directory;
    this.steps = steps;
  }

  // The row of a combination of switches, or the only one.
  row(number, combination) {
    const { at, length, scale, middle } = this.directory[number];
    const row = combination < scale.length ? combination : 0;
    const found = new Array(length);
    for (let i = 0; i < length; i++) {
      const step = this.steps[at + row * length + i];
      found[i] = step === GAP ? null : middle[row] + scale[row] * step;
    }
    return found;
  }
}
