"""Many runs of a model, on any number of processes and machines: plan, workers, parts, one dataset.

plan says which runs there are (sampling, scalars: of what and what of it), job is what a worker does, cluster and local
bring it there, parts keeps finished runs, dataset makes one file of them; study puts these together.
"""
