"""Endings of files that are not read, and how to come to one that is."""

from __future__ import annotations

_SURFACES = "in the CAD system that wrote it, or in FreeCAD, export it as STEP (.step)"
_NATIVE = "open it in the CAD system it is of, and export it as STEP (.step, AP214 or AP242)"
_SCENE = "open it in Blender, and export the objects as glTF (.glb) or STL"
_PACKED = "unpack it, and name the file that is inside"

#: What files of an ending are, and what to do with them.
_FOREIGN: dict[str, tuple[str, str]] = {
    **dict.fromkeys((".stpz", ".step.gz", ".stp.gz"), ("a packed STEP file", "unpack it with gzip, to .step")),
    ".stpx": ("a STEP file in XML (AP242 BO model)", "export it as a STEP file of part 21 (.step)"),
    ".p21": ("a STEP file under another ending", "rename it to .step"),
    **dict.fromkeys((".igs", ".iges"), ("IGES, whose surfaces often do not meet", _SURFACES)),
    **dict.fromkeys((".brep", ".brp"), ("OpenCASCADE's own format", "open it in FreeCAD, and export it as STEP (.step)")),
    ".fcstd": ("a FreeCAD document", "open it in FreeCAD, and export the bodies as STEP (.step)"),
    **dict.fromkeys((".x_t", ".x_b", ".xmt_txt", ".xmt_bin"), ("Parasolid", _SURFACES)),
    **dict.fromkeys((".sat", ".sab"), ("ACIS", _SURFACES)),
    ".jt": ("JT", _SURFACES),
    **dict.fromkeys((".sldprt", ".sldasm"), ("SolidWorks", _NATIVE)),
    **dict.fromkeys((".ipt", ".iam"), ("Inventor", _NATIVE)),
    **dict.fromkeys((".f3d", ".f3z"), ("Fusion", _NATIVE)),
    **dict.fromkeys((".catpart", ".catproduct", ".cgr"), ("CATIA", _NATIVE)),
    **dict.fromkeys((".par", ".psm", ".asm"), ("Solid Edge or Creo", _NATIVE)),
    ".prt": ("NX or Creo", _NATIVE),
    **dict.fromkeys((".3dm", ".skp"), ("Rhino or SketchUp", "export it there as STEP (.step) or 3MF")),
    **dict.fromkeys((".dwg", ".dxf"), ("AutoCAD", "export its solids there as STEP (.step) or STL")),
    ".ifc": ("a building model (IFC)", "open it in FreeCAD or BlenderBIM, and export what is needed as STEP or glTF (.glb)"),
    ".blend": ("a Blender document", _SCENE),
    **dict.fromkeys((".fbx", ".dae", ".3ds", ".abc", ".usd", ".usda", ".usdc", ".usdz", ".x3d", ".wrl", ".vrml"),
                    ("a scene of another kind", _SCENE)),
    ".amf": ("AMF", "open it in a slicer (PrusaSlicer, Cura), and export it as 3MF"),
    ".scad": ("an OpenSCAD program", "run it in OpenSCAD, and export 3MF or STL"),
    **dict.fromkeys((".msh", ".vtk", ".vtu", ".vtp", ".inp"), ("a mesh for computation", "export its surface as STL, with meshio or ParaView")),
    **dict.fromkeys((".e57", ".las", ".laz", ".pcd", ".pts", ".ptx", ".rcp", ".fls"),
                    ("a scan", "open it in CloudCompare, and save it as PLY, or as a text of x y z (.xyz)")),
    **dict.fromkeys((".zip", ".gz", ".7z", ".rar", ".tar", ".xz", ".bz2"), ("an archive", _PACKED)),
}  # fmt: skip


def foreign(ending: str) -> str:
    """Say what a file of an ending with its dot is, and how to convert it; or that no one here knows it."""
    known = _FOREIGN.get(ending.lower())
    if known is None:
        return f"the ending {ending!r} is of no known format." if ending else "the name has no ending that says its format."
    what, advice = known
    return f"{what[:1].upper()}{what[1:]} ({ending}) is not read: {advice}."
