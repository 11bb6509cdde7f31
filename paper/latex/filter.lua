-- What pandoc does not take over from Typst: labels, references to them, numbered equations, and the title.

local function label_of(inline)
  return inline and inline.tag == "Span" and #inline.content == 0 and inline.identifier
end

-- Pandoc puts a label behind what it labels: an equation, a space, the label; or a block, a paragraph with the label.
local function number_equations(inlines)
  for place = #inlines, 1, -1 do
    local math, label = inlines[place], label_of(inlines[place + 2])
    if math.tag == "Math" and math.mathtype == "DisplayMath" then
      local labelled = label and inlines:remove(place + 2) and "\\label{" .. label .. "}" or ""
      local equation = "\\begin{equation}" .. labelled .. "\n" .. math.text .. "\n\\end{equation}"
      inlines[place] = pandoc.RawInline("latex", equation)
    end
  end
  return inlines
end

-- A reference without content is the number alone.
local function refer(link)
  local command = #link.content > 0 and "\\autoref{" or "\\ref{"
  return link.classes:includes("ref") and pandoc.RawInline("latex", command .. link.target:sub(2) .. "}") or link
end

local function place_figure(image)
  image.src = "figures/" .. pandoc.path.filename(image.src)
  return image
end

function Pandoc(document)
  local blocks, meta = pandoc.Blocks({}), document.meta
  for _, block in ipairs(document.blocks) do
    local label = block.tag == "Para" and label_of(block.content[1])
    if label then
      blocks[#blocks].identifier = label
      block.content:remove(1)
    end
    if not label or #block.content > 0 then
      blocks:insert(block)
    end
  end
  meta.title, meta.subtitle, meta.author = blocks[1].content, blocks[2].content, blocks[3].content
  meta.abstract = pandoc.Blocks({})
  while blocks[4].tag ~= "Header" do
    meta.abstract:insert(blocks:remove(4))
  end
  local body = pandoc.Blocks({table.unpack(blocks, 4)})
  document.blocks = body:walk({Inlines = number_equations}):walk({Link = refer, Image = place_figure})
  return document
end
