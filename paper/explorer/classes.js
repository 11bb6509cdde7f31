// Classes of cells, which a colour and a hatching tell apart, so that neither colour vision nor a screen is needed.
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

const OF_OUTCOMES = ["none", "dots", "level", "upright", "cross", "rising", "falling", "none"]
const FAILED = {label: "the run failed", colour: "#000000", hatching: "none", note: ""}
const band = (colour, label, hatching, note = "") => ({colour, label, hatching, note})
const ERRORS = [
  band("#ffffff", "up to 0.01 %", "none"),
  band("#ffeda0", "to 0.1 %", "dots"),
  band("#feb24c", "to 1 %", "level"),
  band("#fd7632", "to 10 %", "rising"),
  band("#d01c20", "to 100 %", "upright"),
  band("#7a0024", "more", "cross"),
  FAILED,
]
const EXPONENTS = [
  band("#2166ac", "below −0.5", "falling", "runs approach each other fast, as where they are damped away"),
  band("#92c5de", "to −0.1", "level", "runs approach each other"),
  band("#ffffff", "to 0.2", "none", "neighbouring runs part in proportion to time at most, as exact ones do"),
  band("#f4a582", "to 0.5", "dots", "runs part slowly"),
  band("#b2182b", "above 0.5", "cross", "runs part by a factor of 1.6 or more each period"),
  FAILED,
]
const CLASSES = {
  outcome: meta.outcomes.map((one, k) => ({...one, hatching: OF_OUTCOMES[k]})),
  error: ERRORS,
  exponent: EXPONENTS,
}
const BOUNDS = {error: [0.01, 0.1, 1, 10, 100], exponent: [-0.5, -0.1, 0.2, 0.5]}

// Index of the class of each cell of a map.
function classesOf(colour, p, s) {
  if (colour === "outcome") return part("outcome", p, s)
  const bounds = BOUNDS[colour], value = colour === "error" ? fromLogarithm : fromExponent
  return Uint8Array.from(part(colour, p, s), (code) => {
    const x = value(code)
    return Number.isNaN(x) ? bounds.length + 1 : bounds.filter((bound) => x > bound).length
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
