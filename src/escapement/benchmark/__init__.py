"""Run time against error: the package's engines beside every solver worth comparing.

`suite.run` measures, `suite.write` fills a folder; nothing is imported before it is used.
"""
