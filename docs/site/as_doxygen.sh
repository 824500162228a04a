#!/bin/sh
# Shows Doxygen a header whose comments are plain ones: those on lines of their own describe what follows, those behind a
# declaration describe it, and the first of a file the file. Indented lines in them are code, equations or tables.
exec awk '
    NR == 1 && /^\/\/ / { print "/// \\file" }
    !/^ *\/\// {
        if (indented) print margin "/// \\endcode"
        indented = 0
        # Doxygen makes links to friends that lead nowhere. Those with a body count as members; the others are not of interest.
        if (/^ *friend .*;$/) next
        if (/^ *friend /) sub(/friend /, "")
        if (match($0, /[;,] +\/\/ /)) $0 = substr($0, 1, RSTART) "  ///< " substr($0, RSTART + RLENGTH)
        print
        next
    }
    {
        match($0, /^ */)
        margin = substr($0, 1, RLENGTH)
        text = substr($0, RLENGTH + 3)
        deeper = text ~ /^   +[^ ]/
        if (deeper != indented) print margin "/// " (deeper ? "\\code{.unparsed}" : "\\endcode")
        indented = deeper
        if (!deeper) gsub(/[@#]/, "\\\\&", text)
        print margin "///" text
    }' "$1"
