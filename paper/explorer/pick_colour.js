
for (const [name, parts] of Object.entries(layers)) {
  for (const part of parts) part.visible = name === colour.value
}
for (const [index, part] of outcomes.entries()) part.visible &&= ["all", String(index)].includes(outcome.value)
