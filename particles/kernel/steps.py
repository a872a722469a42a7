"""The steps of a tracer among scatterers, those of the plane or of space by the type of its lane.

Event loops are written once; which steps they take is chosen when they are compiled.
"""

from particles.compiled.decorators import by_dimension
from particles.kernel import in_plane, in_space

begin = by_dimension(in_plane.begin, in_space.begin)
lacks_cell = by_dimension(in_plane.lacks_cell, in_space.lacks_cell)
make_cell = by_dimension(in_plane.make_cell, in_space.make_cell)
next_contact = by_dimension(in_plane.next_contact, in_space.next_contact)
next_wall = by_dimension(in_plane.next_wall, in_space.next_wall)
cross_cell = by_dimension(in_plane.cross_cell, in_space.cross_cell)
collide = by_dimension(in_plane.collide, in_space.collide)
end_bounces = by_dimension(in_plane.end_bounces, in_space.end_bounces)
note_place = by_dimension(in_plane.note_place, in_space.note_place)
