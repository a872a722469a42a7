"""The commands of `lorentz`: one file each."""
