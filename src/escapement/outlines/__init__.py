"""Outlines: the bodies of a mechanism as closed curves, for drawings and checks.

Points are complex numbers x + iy, in the unit of length that each outline names.

- `curves`, `bodies`: closed curves of lines and arcs, and the bodies that they bound
- `geneva`, `imperfect_edges`, `gears`, `meshed`, `teeth`: bodies of the kinds of mechanism, and
  their teeth
- `touching`: bodies of the kinds whose outlines touch anywhere
- `gaps`, `interference`: the gap between two bodies, and the check of a whole turn
- `part`, `parts`, `thin_walls`, `fits`: flat parts with inertia and thinnest wall, and allowances
- `bores`, `fixtures`: holes for shafts; dowels, washers, base plate and coupon
- `part_record`, `title_block`: what is told of parts, and what their drawing says
- `sheet`, `part_files`, `solids`: the sheet that a file shows, and the files
"""
