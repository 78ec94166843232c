"""The cube on its slab: is it on the right face, seated, headed, settled; and what its faces are."""
