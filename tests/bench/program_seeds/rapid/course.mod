MODULE course
PERS tooldata mill:=[TRUE,[[165,0,405.788],[0,0.96592583,0,-0.25881905]],[38.5,[40,0,180],[1,0,0,0],0,0,0]];
PERS wobjdata part:=[FALSE,FALSE,"STN1",[[0,0,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];
CONST zonedata near:=[FALSE,0.5,0.5,0.5,0.05,0.5,0.05];
CONST speeddata joints:=[500,50,500,20];
CONST speeddata cut:=[20,100,5000,1000];
CONST jointtarget home:=[[0,-15,20,0,55,0],[0,9E9,9E9,9E9,9E9,9E9]];
CONST robtarget above:=[[-100,-50,300],[0.25827583,0,0,-0.96607122],[-1,0,-1,0],[3.3302,9E9,9E9,9E9,9E9,9E9]];
CONST robtarget low:=[[-100,-50,245],[0.10356782,0,0,-0.99462239],[-1,0,-2,0],[62.9696,9E9,9E9,9E9,9E9,9E9]];
CONST num steps{3}:=[4,-2,6];
VAR num row;
VAR robtarget grid{2,2};
PROC main()
ActUnit STN1;
PDispOff;
EOffsOff;
ConfJ\On;
ConfL\Off;
SingArea\Off;
CirPathMode\ObjectFrame;
AccSet 100,100;
VelSet 100,5000;
PathAccLim TRUE\AccMax:=2,TRUE\DecelMax:=2;
MoveAbsJ home\NoEOffs,joints,fine,mill\WObj:=part;

MoveJ above,joints,fine,mill\WObj:=part;
MoveL low,cut,fine,mill\WObj:=part;
row:=0;
WHILE row<2 DO
FOR c FROM 2 TO 1 DO
grid{row+1,c}:=Offs(low,c*5,row*4,0);
ENDFOR
Incr row;
ENDWHILE
FOR r FROM 1 TO 2 DO
FOR c FROM 1 TO 2 STEP 1 DO
TEST r*10+c
CASE 11,22:
there grid{r,c},3;
CASE 12:
there grid{r,c},steps{c}*-1;
DEFAULT:
MoveL grid{r,c},cut,fine,mill\WObj:=part;
ENDTEST
ENDFOR
ENDFOR
IF row=2 AND steps{2}<0 THEN
MoveL Offs(low,steps{1},steps{2}+0.5,Sin(30)),cut,fine,mill\WObj:=part;
ELSEIF row>2 THEN
Stop;
ELSE
MoveL low,cut,near,mill\WObj:=part;
ENDIF
MoveL low,cut,fine,mill\WObj:=part;
ENDPROC
PROC there(robtarget at,num up)
VAR num k:=1;
up:=up+k;
at.trans.x:=at.trans.x+1;
MoveL Offs(at,0,0,up),cut,fine,mill\WObj:=part;
MoveL at,cut,fine,mill\WObj:=part;
ENDPROC
ENDMODULE
