"""Display of scenes, results and tables in notebooks, and their conversion to objects of other libraries."""
