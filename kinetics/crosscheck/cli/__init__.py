"""The commands of `lorentz`, a file each (`bench` holds `stress` too), and what they share.

Their heads import only click and the table of outputs: `lorentz --help` stays quick.
"""
