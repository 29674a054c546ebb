"""Endings of files that are not read, and how to come to one that is."""

from __future__ import annotations

_SURFACES = "in the CAD system that wrote it, or in FreeCAD, export it as STEP (.step)"
_NATIVE = "open it in the CAD system it is of, and export it as STEP (.step, AP214 or AP242)"
_SCENE = "open it in Blender, and export the objects as glTF (.glb) or STL"
_SCAN = "open it in CloudCompare, and save it as PLY, or as a text of x y z (.xyz)"

#: Endings, what such files are, and what to do with them.
_ROWS = (
    (".stpz", "a packed STEP file", "unpack it with gzip, to .step"),
    (".stpx", "a STEP file in XML", "export it as a STEP file of part 21 (.step)"),
    (".p21", "a STEP file under another ending", "rename it to .step"),
    (".igs .iges", "IGES, whose surfaces often do not meet", _SURFACES),
    (".brep .brp", "OpenCASCADE's own format", "open it in FreeCAD, and export it as STEP (.step)"),
    (".fcstd", "a FreeCAD document", "open it in FreeCAD, and export the bodies as STEP (.step)"),
    (".x_t .x_b .xmt_txt .xmt_bin", "Parasolid", _SURFACES),
    (".sat .sab", "ACIS", _SURFACES),
    (".jt", "JT", _SURFACES),
    (".sldprt .sldasm", "a SolidWorks document", _NATIVE),
    (".ipt .iam", "an Inventor document", _NATIVE),
    (".f3d .f3z", "a Fusion document", _NATIVE),
    (".catpart .catproduct .cgr", "a CATIA document", _NATIVE),
    (".par .psm .asm", "a Solid Edge or Creo document", _NATIVE),
    (".prt", "an NX or Creo document", _NATIVE),
    (".3dm .skp", "a Rhino or SketchUp document", "export it there as STEP (.step) or 3MF"),
    (".dwg .dxf", "an AutoCAD drawing", "export its solids there as STEP (.step) or STL"),
    (".ifc", "a building model", "open it in FreeCAD, and export what is needed as STEP (.step)"),
    (".blend", "a Blender document", _SCENE),
    (".fbx .3ds .abc .usd .usda .usdc .usdz .x3d .wrl .vrml", "a scene in another format", _SCENE),
    (".amf", "AMF", "open it in a slicer (PrusaSlicer, Cura), and export it as 3MF"),
    (".scad", "an OpenSCAD program", "run it in OpenSCAD, and export 3MF or STL"),
    (".msh .vtk .vtu .vtp .inp", "a mesh for computation", "save its surface as STL, in ParaView or Gmsh"),
    (".rcp .fls", "a scan in another format", _SCAN),
    (".zip .gz .7z .rar .tar .xz .bz2", "an archive", "unpack it, and name the file that is inside"),
)
_FOREIGN = {ending: (what, advice) for endings, what, advice in _ROWS for ending in endings.split()}


def foreign(ending: str) -> str:
    """Say what a file of an ending with its dot is, and how to convert it; or that no one here knows it."""
    if not ending:
        return "the name has no ending that says its format."
    if ending.lower() not in _FOREIGN:
        return f"the ending {ending!r} is of no known format."
    what, advice = _FOREIGN[ending.lower()]
    return f"{what[:1].upper()}{what[1:]} ({ending}) is not read: {advice}."
