// The map of one scheme: cells on a canvas, axes and marks above them.
const MARGIN = {left: 50, right: 8, top: 8, bottom: 38}
const STEPS = [100, 50, 20, 10, 5, 2, 1]

// Places of the edges of cells whose middles are evenly spaced in the logarithm.
function edgesOf(values) {
  const logs = values.map(Math.log10), half = (logs.at(-1) - logs[0]) / (logs.length - 1) / 2
  return [logs[0] - half, logs.at(-1) + half]
}

function frameOf(width, p) {
  const [left, right] = edgesOf(meta.parts), [low, high] = edgesOf(Array.from(part("u0", p)))
  const height = Math.round(Math.min(Math.max(0.68 * width, 240), 470))
  const inner = {width: width - MARGIN.left - MARGIN.right, height: height - MARGIN.top - MARGIN.bottom}
  return {
    width, height, inner, low, high,
    x: (step) => MARGIN.left + ((Math.log10(step) - left) / (right - left)) * inner.width,
    y: (u0) => MARGIN.top + ((high - Math.log10(u0)) / (high - low)) * inner.height,
    column: (x) => Math.floor(((x - MARGIN.left) / inner.width) * meta.parts.length),
    row: (y) => Math.floor((1 - (y - MARGIN.top) / inner.height) * meta.amplitudes.length),
  }
}

function drawCells(canvas, frame, colour, p, s) {
  const ratio = devicePixelRatio || 1, {inner} = frame
  canvas.style.cssText = `left:${MARGIN.left}px;top:${MARGIN.top}px;width:${inner.width}px;height:${inner.height}px`
  canvas.width = Math.round(inner.width * ratio)
  canvas.height = Math.round(inner.height * ratio)
  const pen = canvas.getContext("2d"), of = classesOf(colour, p, s)
  const [rows, columns] = [meta.amplitudes.length, meta.parts.length]
  // edges fall on whole pixels, so that no background shines through between two cells
  const edge = (k, count, size) => Math.round((k * size) / count)
  CLASSES[colour].forEach((one, k) => {
    if (!of.includes(k)) return
    pen.beginPath()
    for (let place = 0; place < of.length; place++) {
      if (of[place] !== k) continue
      const [i, j] = [Math.floor(place / columns), place % columns]
      const [x, y] = [edge(j, columns, canvas.width), edge(rows - 1 - i, rows, canvas.height)]
      pen.rect(x, y, edge(j + 1, columns, canvas.width) - x, edge(rows - i, rows, canvas.height) - y)
    }
    fillAs(pen, one, () => pen.fill())
  })
}

function axes({x, y, inner, low, high, width, height}) {
  const bottom = MARGIN.top + inner.height, right = MARGIN.left + inner.width
  const ticks = STEPS.map((n) => {
    const at = x(1 / n)
    return `<path class="axis" d="M${at} ${bottom}v5"/>
      <text x="${at}" y="${bottom + 17}" text-anchor="middle">${n === 1 ? "T" : `T/${n}`}</text>`
  })
  for (let power = Math.ceil(low); power <= high; power++) {
    const at = y(10 ** power)
    ticks.push(`<path class="axis" d="M${MARGIN.left} ${at}h-5"/>
      <text x="${MARGIN.left - 8}" y="${at + 4}" text-anchor="end">${10 ** power}</text>`)
  }
  return `${ticks.join("")}
    <rect class="axis" x="${MARGIN.left}" y="${MARGIN.top}" width="${inner.width}" height="${inner.height}"/>
    <path class="twenty" d="M${x(1 / 20)} ${MARGIN.top}V${bottom}"/>
    <text x="${(MARGIN.left + right) / 2}" y="${height - 4}" text-anchor="middle">step size Δt</text>
    <text transform="translate(11 ${MARGIN.top + inner.height / 2}) rotate(-90)" text-anchor="middle">amplitude u₀</text>`
}

const STAR = Array.from({length: 10}, (_, k) => {
  const [angle, radius] = [(Math.PI * k) / 5 - Math.PI / 2, k % 2 ? 3.6 : 9]
  return `${(radius * Math.cos(angle)).toFixed(2)},${(radius * Math.sin(angle)).toFixed(2)}`
}).join(" ")

// Place of a run on the map: the middle of its cell, or where the paper's run truly lies.
function placeOf(run, p, {x, y}) {
  const one = meta.cases[run.case]
  return one ? [x(one.dt / one.period), y(one.u0)] : [x(meta.parts[run.j]), y(part("u0", p, run.i)[0])]
}

// Stars of the paper, the kept run, the run that is looked at, and the largest safe step of its amplitude.
function marks(frame, choice, shown, side) {
  const p = choice.problem, {x, y} = frame
  const double = (shape) => `<g stroke-width="4" class="halo">${shape}</g><g stroke-width="1.8" class="over">${shape}</g>`
  const safe = part("largest_accurate", p, choice.schemes[side], shown.i)[0]
  const row = y(part("u0", p, shown.i)[0])
  const bar = safe > 0 ? double(`<path d="M${MARGIN.left} ${row}H${x(safe)}m0 -6v12"/>`) : ""
  const stars = meta.cases.filter((one) => one.problem === meta.problems[p].name).map((one) =>
    `<polygon class="star" points="${STAR}" transform="translate(${x(one.dt / one.period)} ${y(one.u0)})"/>`)
  const [px, py] = placeOf(choice.run, p, frame), [sx, sy] = placeOf(shown, p, frame)
  const kept = double(`<circle cx="${px}" cy="${py}" r="12"/>`)
  const looked = sameRun(shown, choice.run) ? "" : double(`<rect x="${sx - 7}" y="${sy - 7}" width="14" height="14"/>`)
  return `${bar}${stars.join("")}${kept}${looked}`
}

// The run at a place of the map: one of the paper's if a star is near, otherwise that of the cell.
function runAt(left, top, p, frame) {
  const near = meta.cases.findIndex((one, k) => {
    const [x, y] = placeOf({case: k}, p, frame)
    return one.problem === meta.problems[p].name && Math.hypot(left - x, top - y) < 11
  })
  return near >= 0 ? caseRun(near) : cellRun(frame.row(top), frame.column(left))
}
