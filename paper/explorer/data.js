// The data of the page. `meta` describes them, and the arrays lie one after the other in one compressed text.
const meta = JSON.parse(document.getElementById("meta").textContent)
const TYPES = {float32: Float32Array, int16: Int16Array, uint8: Uint8Array}
const blocks = await unpacked(document.getElementById("content").textContent, meta.blocks)

async function unpacked(text, places) {
  const letters = atob(text), bytes = new Uint8Array(letters.length)
  for (let k = 0; k < letters.length; k++) bytes[k] = letters.charCodeAt(k)
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"))
  const buffer = await new Response(stream).arrayBuffer()
  const of = ({offset, type, shape}) => {
    const size = shape.reduce((product, length) => product * length, 1)
    return {values: new TYPES[type](buffer, offset, size), shape}
  }
  return Object.fromEntries(Object.entries(places).map(([name, place]) => [name, of(place)]))
}

// The part of a block at some indices of its first dimensions.
function part(name, ...indices) {
  const {values, shape} = blocks[name]
  const rest = shape.slice(indices.length).reduce((product, length) => product * length, 1)
  const start = indices.reduce((place, index, k) => place * shape[k] + index, 0) * rest
  return values.subarray(start, start + rest)
}

const fromCode = (code) => (code === -32768 ? NaN : code === 32767 ? Infinity : 2 ** (code / meta.codes))

// Index of the value that is nearest in ratio.
function nearest(values, wanted) {
  const apart = values.map((value) => Math.abs(Math.log(value / wanted)))
  return apart.indexOf(Math.min(...apart))
}
