"""One script a question, and a tour; `python -m experiments` lists them."""
