"""What is in an FMU beside its binary: modelDescription.xml, documentation, icon, terminals, reference result.

All of it is made of the description of a mechanism, which the C++ side gives (modelDescription/describe.h), for the
mechanisms of models/ by the build and for those of files by `sigmafmu.build_fmu`:

    modelDescription.xml
    model.png                             the icon, drawn from the mechanism
    documentation/index.html              with a figure of the mechanism and text from docs/
    documentation/licenses/               entry point license.txt
    terminalsAndIcons/                    FMI 3.0's terminals, which FMI 2.0.4 adopted
    extra/org.fmi-standard.fmi-ls-ref/    reference result with its error bounds, and documentation/fmi-ls-ref.html

The build runs this before the package sigmafmu is installed, so nothing here imports it.
"""
