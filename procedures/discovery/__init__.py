"""Terms that no catalogue holds, found: a library made by machine, its scores, and which of them stand."""
