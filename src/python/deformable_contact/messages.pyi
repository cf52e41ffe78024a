# The messages' fields as numpy arrays; the module's docstring says which.
from typing import Any, List, Optional

import genpy
import numpy
from std_msgs.msg import Header

def publish_mesh(topic: str, vertices: Any, triangles: Any, frame: str = ..., name: str = ...,
                 stamp: Optional[genpy.Time] = ...) -> None: ...

GEOMETRY: numpy.dtype
STATE: numpy.dtype

class ContactArray(genpy.Message):
    LINK: int
    DEFORMABLE: int
    RIGID: int
    header: Header
    cycle: int
    bodies: List[str]
    body_kind: numpy.ndarray
    triggered: numpy.ndarray
    body_stamps: List[genpy.Time]
    topology_ids: numpy.ndarray
    pairs: numpy.ndarray
    geometry: numpy.ndarray
    nearest: List[Any]
    pair_count: int
    complete: bool
    guaranteed: bool
    truncated: bool
    timed_out: bool
    undecided: int
    rejected_triangles: int
    skipped: List[str]
    backend: str
    predicates: str
    overlap: float
    tolerance: float
    compute_time: genpy.Duration
    age: genpy.Duration
    def __init__(self, *args: Any, **kwds: Any) -> None: ...
    def serialize(self, buff: Any) -> None: ...
    def deserialize(self, buffer: Any) -> ContactArray: ...

class ContactStates(genpy.Message):
    header: Header
    cycle: int
    age: genpy.Duration
    complete: bool
    tolerance: float
    states: numpy.ndarray
    def __init__(self, *args: Any, **kwds: Any) -> None: ...
    def serialize(self, buff: Any) -> None: ...
    def deserialize(self, buffer: Any) -> ContactStates: ...

class DeformableMesh(genpy.Message):
    header: Header
    object: str
    topology_id: int
    vertices: numpy.ndarray
    triangles: numpy.ndarray
    def __init__(self, *args: Any, **kwds: Any) -> None: ...
    def serialize(self, buff: Any) -> None: ...
    def deserialize(self, buffer: Any) -> DeformableMesh: ...

class LinkMesh(genpy.Message):
    link: str
    source: str
    vertices: numpy.ndarray
    triangles: numpy.ndarray
    def __init__(self, *args: Any, **kwds: Any) -> None: ...
    def serialize(self, buff: Any) -> None: ...
    def deserialize(self, buffer: Any) -> LinkMesh: ...

class LinkMeshes(genpy.Message):
    header: Header
    meshes: List[LinkMesh]
    def __init__(self, *args: Any, **kwds: Any) -> None: ...
    def serialize(self, buff: Any) -> None: ...
    def deserialize(self, buffer: Any) -> LinkMeshes: ...
