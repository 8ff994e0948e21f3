"""NC programs that ask too much of nist-octahedral, each in another way of writing."""

TOO_FAST = {
    "lines": "G21 G90 G61\nG1 X200 F40000\nY150\nX-200 Z80 F30000\nG0 X0 Y0 Z0\nG1 X50 F500\nM2\n",
    "incremental": "G21 G91 G64\nG1 X200 F40000\nY150 X-100\nG2 X50 Y50 I50 J0\nG3 X-50 Y-50 R50 F35000\nG1 X3\nM2\n",
    "inch": "G20 G90\nG1 X8 F1500\nG3 X0 Y4 I-4 J2 Z1\nG1 X0 Y0\nM2\n",
    "inverse time": "G21 G93 G90\nG1 X200 F200\nG1 X0 F250\nG3 X0 Y100 J50 I0 F150\nG94\nG1 X10 F400\nM2\n",
    "loop": "G21 G90\n#1=3\nF40000\no1 while [#1 gt 0]\nG1 X200\nG1 X[-100-#1]\n#1=[#1-1]\no1 endwhile\n"
    "G1 X0 F300\nY20\nM2\n",
    "subroutine": "G21 G90\no<a> sub\nG1 X#1 F#2\nX0\no<a> endsub\n"
    "o<a> call [100] [40000]\no<a> call [150] [20000]\nM2\n",
    "helix": "G21 G90 G17\nG1 X100 F30000\nG3 X100 Y0 I-100 J0 Z40 P3\nG18 G2 X0 Z140 I-100 K0\n"
    "G19 G3 Y100 Z40 J0 K-100\nM2\n",
    "absolute centre": "G21 G90 G90.1\nG1 X100 F40000\nG3 X-100 Y0 I0 J0\nG1 X0\nM2\n",
    "turned": "G21 G90\nG10 L2 P1 X20 Y10 R30\nG54\nG1 X0 Y0 F2000\nG1 X150 F40000\nG3 X0 Y150 I-150 J0\nG1 Y0\nM2\n",
    "tool angle": "G21 G90\nG1 A15 F20000\nG1 X150 B10 A-10 F40000\nG1 B0 A0\nX0\nM2\n",
    "exact stop": "%\nG21 G90 G61.1\nN10 G1 X200 F40000 (out)\nN20 X-200\nN30 G1 X0 ; home\n%\n",
    "line feeds": "G21 G90\r\nG1 X200 F40000 (a)\r\nX0 ; b\r\nM2\r\n",
    "offset": "G21 G90\nG92 X10 Y10\nG1 X200 F40000 Z10\nX0 Y0\nG52 X5\nX150\nM2\n",
    "other words": "G21 G90\nG1 X200 F40000 M8\nG64 P0.01 X-200 S100\nX0 F 900\nM2\n",
    "rounded": "G21 G90 G64 P0.5\nG1 X200 F40000\nY100\nX-200 Y0\nX0\nM2\n",
    "formula": "G21 G90\n#1=40000\nG1 X200 F#1 (out)\nX0 F[#1 / 2] M9\nM2\n",
}
