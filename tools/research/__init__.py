"""What proves the product: the study of the methods, measurements, and reference solutions.

`python -m research` is its command, in the private environment of `make setup`. Nothing of it is installed with
`sigmafmu`, and `sigmafmu` knows nothing of it.
"""
