"""What depends on the compiler: how kernels are compiled and cached, and the innermost search.

May import: `particles.events`; nothing else of the package.
Begin reading with `decorators` and `cache`, then `slots`, the search as a plain loop; `vectors` is
the same search in LLVM's instructions and `search` chooses between the two.
"""
