"""What a run and each of its effects will cost on this machine: counted work times prices that were measured once.

`counts` tells the work of a scene by units, `samples` are the short runs that prices are found from, `price_list` is
what is kept of them, and `foreseen` puts both together.
"""
