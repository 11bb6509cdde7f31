// The page: choices, the largest safe steps, two maps, and the chosen run by the schemes of both.
const $ = (selector, inside = document) => inside.querySelector(selector)
const SITE = $("#site").getAttribute("href").replace("index.html", "")
const escaped = (text) => text.replace(/&/g, "&amp;").replace(/</g, "&lt;")
const sides = [0, 1].map((side) => ({map: $(`.map[data-side="${side}"]`), run: $(`.run[data-side="${side}"]`)}))
let choice = choiceOf(location.hash)
let answer // the tables of safe steps; they stay while they hold, so that a button in them keeps the focus
let keeping // the timer that puts the choice into the address, which browsers allow a few times a second

function choose(change) {
  choice = {...choice, ...change}
  clearTimeout(keeping)
  keeping = setTimeout(() => history.replaceState(null, "", addressOf(choice)), 150)
  draw()
}

function fill(select, list, value) {
  select.replaceChildren(...list.map(([name, title]) => new Option(title, name, false, name === String(value))))
}

// A run moved along the axes of the maps by a number of cells.
const runMoved = (columns, rows) => ({
  step: columns ? moved(meta.steps, choice.step, columns) : choice.step,
  u0: rows ? moved(amplitudesOf(choice), choice.u0, rows) : choice.u0,
})

function build() {
  // another spring keeps the relative amplitude
  $("#problem").onchange = ({target: {value}}) =>
    choose({problem: +value, u0: (choice.u0 / meta.problems[choice.problem].unit) * meta.problems[value].unit})
  $("#error").onchange = ({target}) => choose({error: +target.value})
  $("#colour").onchange = ({target}) => choose({colour: target.value})
  $("#u0").onchange = ({target: {value}}) => choose(value > 0 ? {u0: within(amplitudesOf(choice), +value)} : {})
  $("#steps").onchange = ({target: {value}}) => choose(value > 0 ? {step: within(meta.steps, 1 / value)} : {})
  for (const button of document.querySelectorAll("[data-move]"))
    button.onclick = () => choose(runMoved(...button.dataset.move.split(",").map(Number)))
  $("#answer").onclick = ({target: {dataset: {scheme, step}}}) => {
    if (!step) return
    $("#side0").checked = true
    const run = {u0: cellOf(choice).u0, step: meta.steps[nearest(meta.steps, +step)]}
    choose({schemes: [+scheme, choice.schemes[1]], ...run})
    $(".sides").scrollIntoView({block: "nearest"})
  }
  $("#cases").append(...meta.cases.map(({problem, u0, dt}) => {
    const button = document.createElement("button"), p = indexOf(meta.problems, problem)
    button.textContent = `★ ${meta.problems[p].title}, u₀ = ${short(u0)}`
    button.onclick = () => choose({problem: p, u0, step: dt / periodAt({problem: p, u0})})
    return button
  }))
  sides.forEach((place, side) => {
    place.run.innerHTML = `<div aria-live="polite"></div><div class="figures"></div>`
    place.map.innerHTML = `<p><select aria-label="scheme"></select><a></a></p><div class="plane" tabindex="0" role="application"
      aria-roledescription="map of runs" aria-describedby="keys"><canvas></canvas><svg aria-hidden="true"></svg></div>`
    $("select", place.map).onchange = ({target}) =>
      choose({schemes: choice.schemes.map((s, k) => (k === side ? +target.value : s))})
    place.plane = $(".plane", place.map)
    place.plane.onclick = ({clientX, clientY}) => {
      const {left, top} = place.plane.getBoundingClientRect()
      choose(place.frame.runAt(clientX - left, clientY - top))
    }
    place.plane.onpointermove = (event) => event.buttons && event.pointerType === "mouse" && place.plane.onclick(event)
    place.plane.onkeydown = onKey
  })
  new ResizeObserver(draw).observe($(".sides"))
  matchMedia("(prefers-color-scheme: dark)").onchange = draw
  addEventListener("hashchange", () => { choice = choiceOf(location.hash); draw() })
}

const ARROWS = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1]}
function onKey(event) {
  const move = ARROWS[event.key], by = event.shiftKey ? 5 : 1
  if (!move) return
  choose(runMoved(by * move[0], by * move[1]))
  event.preventDefault()
}

// Rows of the schemes of a kind, the largest safe step first.
function rowsOf(explicit) {
  const {i, u0} = cellOf(choice), period = periodAt({...choice, u0})
  const steps = meta.schemes.map((scheme, s) => ({...scheme, s, step: safeStep(choice, s, i)}))
  const chosen = steps.filter((scheme) => scheme.explicit === explicit).sort((a, b) => b.step - a.step)
  return chosen.map(({name, title, s, step, forces, forcesPerIteration}) => {
    const perStep = explicit ? `${forces} a step, ${Math.ceil(forces / step)} a period`
      : `${forces ? `${forces} a step and ` : ""}${forcesPerIteration} an iteration`
    return `<tr><th scope="row"><a href="${SITE}schemes/${name}.html">${escaped(title)}</a></th>${step > 0
      ? `<td><button data-scheme="${s}" data-step="${step}" aria-label="show the run of ${escaped(title)} at
        ${short(step * period)}">${short(step * period)}</button></td><td>${short(1 / step)}</td><td>${perStep}</td>`
      : `<td colspan="3">none: even ${stepName(meta.steps[0])} is not safe</td>`}</tr>`
  }).join("")
}

// The decisions of the study on the chosen spring as a list; empty without a decision.
function decisionsOf({problem, error}) {
  const {name, unit} = meta.problems[problem]
  const decisions = meta.decisions.filter((decision) => decision.problem === name && Math.abs(decision.error / error - 1) < 1e-9)
  const items = decisions.map(({quantity, kind, title, steps}) => `<li>${quantity}, ${kind}: ${title
    ? `${escaped(title)}, ${steps} steps a period` : "no step that was tried"}</li>`)
  return decisions.length ? `<p class="note">From ${decisions[0].starts} starts of the motion of u₀ = ${short(unit)}, at rest and in
    motion, an error within ${error}\u00a0% over ${decisions[0].periods} periods needs the fewest forces, or up to a tenth more, with:</p><ul class="decisions">${items.join("")}</ul>` : ""
}

function drawAnswer() {
  const {u0} = cellOf(choice)
  $("#question").textContent = `Largest safe steps: ${meta.problems[choice.problem].title}, u₀ = ${short(u0)}, ` +
    `energy and period within ${choice.error}\u00a0%`
  const tables = [["Implicit schemes", 0], ["Explicit schemes", 1]].map(([title, explicit]) => `<table>
    <caption>${title}</caption><thead><tr><th scope="col">scheme</th><th scope="col">Δt</th>
    <th scope="col">steps a period</th><th scope="col">forces</th></tr></thead><tbody>${rowsOf(explicit)}</tbody></table>`
  ).join("")
  const all = tables + decisionsOf(choice)
  if (all !== answer) $("#answer").innerHTML = answer = all
}

function drawLegend() {
  const list = document.createElement("ul")
  for (const category of classesFor(choice.colour)) {
    const item = document.createElement("li")
    item.append(swatch(category))
    item.insertAdjacentHTML("beforeend", `<span>${category.label}${category.note ? `<small>: ${category.note}</small>` : ""}</span>`)
    list.append(item)
  }
  $(".legend").replaceChildren(list)
}

function draw() {
  const titles = choice.schemes.map((s) => meta.schemes[s].title), problem = meta.problems[choice.problem].title
  fill($("#problem"), meta.problems.map(({title}, p) => [String(p), title]), choice.problem)
  fill($("#error"), meta.errors.map((error) => [String(error), `${error} %`]), choice.error)
  fill($("#colour"), Object.entries(COLOURS), choice.colour)
  $("#u0").value = +choice.u0.toPrecision(4)
  $("#steps").value = +(1 / choice.step).toPrecision(4)
  document.title = `${titles.join(", ")}: which step can be trusted on the ${problem}?`
  drawAnswer()
  const runs = choice.schemes.map((s) => runOf(choice, s)), computed = runs.filter(Boolean)
  const window = computed.length && {u: limits(computed, "u"), v: limits(computed, "v")}
  // a narrow screen hides one of the maps
  const wide = Math.max(...sides.map(({map}) => map.clientWidth))
  sides.forEach((place, side) => {
    const s = choice.schemes[side], {name, title} = meta.schemes[s], link = $("a", place.map)
    $(`label[for="side${side}"]`).textContent = title
    fill($("select", place.map), meta.schemes.map(({title}, s) => [String(s), title]), s)
    link.href = `${SITE}schemes/${name}.html`
    link.textContent = `about ${title}`
    place.plane.setAttribute("aria-label", `${title}: ${COLOURS[choice.colour]} over step size and amplitude`)
    place.frame = frameOf(wide, choice)
    place.plane.style.height = `${place.frame.height}px`
    drawCells($("canvas", place.plane), place.frame, choice, s)
    $("svg", place.plane).innerHTML = `${axes(place.frame)}${marks(place.frame, choice, side)}`
    const [words, figures] = place.run.children
    words.innerHTML = summary(choice, s, runs[side])
    $("[data-class]", words).prepend(swatch(classesFor("outcome")[$("[data-class]", words).dataset.class]))
    figures.innerHTML = runs[side] ? drawn(runs[side], window, escaped(title)) : ""
  })
  drawLegend()
}

build()
draw()
document.documentElement.dataset.ready = ""
