"""What scenes, results and tables show of themselves in a notebook, and what other libraries take from them."""
