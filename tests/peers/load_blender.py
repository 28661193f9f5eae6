"""blender -b --factory-startup --python load_blender.py -- FILE.glb: imports a file; prints `blender: {json}`."""
import json
import sys

import bpy
import numpy

numpy.bool = bool  # Debian 12: Blender 3.4 asks numpy 1.24 for a name that it dropped
bpy.ops.wm.read_factory_settings(use_empty=True)
try:
    bpy.ops.import_scene.gltf(filepath=sys.argv[-1])
    meshes = [o for o in bpy.data.objects if o.type == "MESH"]
    triangles = sum(len(p.vertices) - 2 for o in meshes for p in o.data.polygons)
    print("blender: " + json.dumps({"objects": len(bpy.data.objects), "meshes": len(meshes), "triangles": triangles,
                                    "images": len(bpy.data.images)}))
except Exception as error:  # the importer raises what it likes
    print("blender: " + json.dumps({"error": next((line for line in str(error).splitlines() if "Error" in line), str(error))[:200]}))
