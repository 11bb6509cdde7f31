// Classes of cells, which a colour and a hatching distinguish, so that neither colour vision nor a screen is needed.
const HATCHINGS = {
  none: () => {},
  dots: (pen) => pen.fillRect(2.5, 2.5, 1.5, 1.5),
  level: (pen) => pen.fillRect(0, 2.5, 6, 1),
  upright: (pen) => pen.fillRect(2.5, 0, 1, 6),
  cross: (pen) => { pen.fillRect(0, 2.5, 6, 1); pen.fillRect(2.5, 0, 1, 6) },
  rising: (pen) => slanted(pen, 1),
  falling: (pen) => slanted(pen, -1),
}

function slanted(pen, sign) {
  pen.beginPath()
  for (const shift of [-6, 0, 6]) {
    pen.moveTo(shift, sign > 0 ? 6 : 0)
    pen.lineTo(shift + 6, sign > 0 ? 0 : 6)
  }
  pen.stroke()
}

const OF_OUTCOMES = Object.keys(HATCHINGS)
const BOUNDS = [0.1, 1, 10, 100]
const BANDS = [
  {colour: "#ffffff", label: "up to 0.1 %", hatching: "none"},
  {colour: "#ffeda0", label: "to 1 %", hatching: "dots"},
  {colour: "#fd9a45", label: "to 10 %", hatching: "rising"},
  {colour: "#d01c20", label: "to 100 %", hatching: "upright"},
  {colour: "#7a0024", label: "more", hatching: "cross"},
  {colour: "#000000", label: "failed, or without a period", hatching: "none"},
]
const classesFor = (colour) => (colour === "outcome"
  ? meta.outcomes.map((one, k) => ({...one, hatching: OF_OUTCOMES[k % OF_OUTCOMES.length]})) : BANDS)

// Index of the class of each cell of a map.
function classesOf(colour, p, s) {
  if (colour === "outcome") return part("outcome", p, s)
  const [energy, period] = [part("energy", p, s), part("period", p, s)]
  return Uint8Array.from(energy, (_, k) => {
    const errors = {energy: fromCode(energy[k]), period: fromCode(period[k])}
    const x = errors[colour] ?? Math.max(errors.energy, errors.period)
    return Number.isNaN(x) ? BOUNDS.length + 1 : BOUNDS.filter((bound) => x > bound).length
  })
}

// Fill what `shape` draws with the colour and the hatching of a class.
function fillAs(pen, {colour, hatching}, shape) {
  const tile = document.createElement("canvas"), ratio = devicePixelRatio || 1
  tile.width = tile.height = Math.round(6 * ratio)
  const small = tile.getContext("2d")
  small.scale(tile.width / 6, tile.height / 6)
  small.fillStyle = small.strokeStyle = isDark(colour) ? "#ffffff99" : "#00000080"
  HATCHINGS[hatching](small)
  pen.fillStyle = colour
  shape(pen)
  pen.fillStyle = pen.createPattern(tile, "repeat")
  shape(pen)
}

function isDark(colour) {
  const [red, green, blue] = [1, 3, 5].map((at) => parseInt(colour.slice(at, at + 2), 16))
  return 0.3 * red + 0.59 * green + 0.11 * blue < 110
}

function swatch(one) {
  const canvas = document.createElement("canvas"), ratio = devicePixelRatio || 1
  canvas.className = "swatch"
  canvas.width = 26 * ratio
  canvas.height = 18 * ratio
  fillAs(canvas.getContext("2d"), one, (pen) => pen.fillRect(0, 0, canvas.width, canvas.height))
  return canvas
}
